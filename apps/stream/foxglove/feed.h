#pragma once

#include "stream/foxglove/channels.h"
#include "stream/foxglove/cloud_payload.h"
#include "stream/foxglove/image_feed.h"
#include "stream/network/text.h"
#include "stream/server/frame_hub.h"
#include "stream/server/session.h"

#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace fuse_flow::stream::foxglove {

/** \brief What all clients of Foxglove's protocol share: the channels, and each frame as they want it, which is made once, and only if one of
 *  them asks. It is made on a thread of its own, so that clients of other protocols do not wait for it. Many threads may use it. */
class Feed {
 public:
  /** \param threads of decoding, 0: one for each core */
  Feed(std::shared_ptr<network::FrameHub> hub, network::Notices& notices, int threads);
  ~Feed();
  Feed(const Feed&) = delete;
  Feed& operator=(const Feed&) = delete;

  /** \brief Nothing is made any more. */
  void stop();

  void describe(const Description& description);
  /** \brief See Server::publishImage(). \return whether there is a channel more, of which clients should be told */
  bool publishImage(std::size_t camera, const ImageView<Rgb8>& pixels, std::uint64_t time,
                    std::shared_ptr<const void> owner);
  bool imageWanted(std::size_t camera) const;
  ImageFeed& images() { return images_; }
  std::shared_ptr<const Channels> channels() const;
  /** \brief Another text for each start of a server: clients forget what an earlier one told them. */
  const std::string& session() const { return session_; }

  /** \brief Somebody wants clouds, or does not want them any more: without anybody, none is kept. */
  void subscribed();
  void unsubscribed();
  /** \brief The frame, or a newer one, if it is there; else it is made, and Channel::wake() follows. */
  std::shared_ptr<const CloudPayload> request(const std::shared_ptr<const network::PublishedFrame>& frame,
                                              const std::weak_ptr<network::Channel>& channel);
  /** \brief The newest that is made; null: there is none. */
  std::shared_ptr<const CloudPayload> newest() const;
  /** \brief PublishedFrame::sequence of the last one that could not be made; 0: none. */
  std::uint64_t failed() const;

 private:
  void run();
  std::shared_ptr<const CloudPayload> made(CloudPayloads& payloads, const network::PublishedFrame& frame);

  const std::shared_ptr<network::FrameHub> hub_;
  network::Notices& notices_;
  const int threads_;
  const std::string session_;
  ImageFeed images_;
  mutable std::mutex mutex_;
  // The mutex guards the following members.
  std::condition_variable wanted_;
  Description description_;
  std::shared_ptr<const Channels> channels_{std::make_shared<const Channels>()};
  std::size_t subscribers_{0};
  std::shared_ptr<const network::PublishedFrame> next_;   ///< to be made
  std::vector<std::weak_ptr<network::Channel>> waiting_;  ///< for it
  std::shared_ptr<const CloudPayload> newest_;
  std::uint64_t failed_{0};
  bool stopped_{false};
  std::thread thread_;  ///< from the first request on
};

}  // namespace fuse_flow::stream::foxglove
