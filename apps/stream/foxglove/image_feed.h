#pragma once

#include "stream/network/text.h"
#include "stream/server/session.h"

#include <fuse_flow/depth_view.h>

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>

namespace fuse_flow::stream::foxglove {

/** \brief An image as foxglove.CompressedImage, for all who want it. */
struct ImagePayload {
  std::uint64_t sequence{0};  ///< 1, 2, 3, … of all images of the server
  std::uint64_t time{0};      ///< nanoseconds since 1970
  std::string message;
};

/** \brief An image as it came. */
struct RawImage {
  ImageView<Rgb8> pixels;
  std::shared_ptr<const void> owner;  ///< of the pixels; null: they are gone when publish() has returned
  std::uint64_t time{0};              ///< nanoseconds since 1970
  std::string frame;                  ///< of the camera
};

/** \brief The newest image of each channel, as JPEG. It is encoded once, on a thread of its own, and only when a client that has subscribed can take
 *  it; what is replaced before that is not encoded. Of a channel it holds one image that waits, one that is encoded, and the newest JPEG; of
 *  one without subscribers nothing. Many threads may use it. */
class ImageFeed {
 public:
  explicit ImageFeed(network::Notices& notices) : notices_(notices) {}
  ~ImageFeed() { stop(); }
  ImageFeed(const ImageFeed&) = delete;
  ImageFeed& operator=(const ImageFeed&) = delete;

  /** \brief Nothing is encoded any more. */
  void stop();

  void subscribe(std::uint32_t channel, const std::weak_ptr<network::Channel>& client);
  void unsubscribe(std::uint32_t channel, const std::weak_ptr<network::Channel>& client);
  /** \brief Whether anybody has subscribed. */
  bool wanted(std::uint32_t channel) const;
  /** \brief Replaces the one that waits, and wakes those who have subscribed. */
  void publish(std::uint32_t channel, RawImage image);

  /** \brief The newest, if it is newer than `after`; null: there is none, or it is being encoded, and Channel::wake() follows.
   *  \param waits_for of this client and channel, 0 at first: with it a client gets what it has waited for, even if another image has come since */
  std::shared_ptr<const ImagePayload> request(std::uint32_t channel, std::uint64_t after, std::uint64_t& waits_for);
  /** \brief Images so far. */
  std::uint64_t encoded() const { return encoded_; }

 private:
  struct Slot {
    std::set<std::weak_ptr<network::Channel>, std::owner_less<>> subscribers;
    std::shared_ptr<const RawImage> raw;  ///< newer than made
    std::uint64_t raw_sequence{0};
    bool requested{false};    ///< raw
    std::uint64_t making{0};  ///< sequence of what is being encoded; 0: nothing
    std::shared_ptr<const ImagePayload> made;
  };

  void run();
  /** \brief The next in turn whose image is requested. */
  std::map<std::uint32_t, Slot>::iterator next();
  std::shared_ptr<const ImagePayload> made(const RawImage& image, std::uint64_t sequence);

  network::Notices& notices_;
  std::atomic<std::uint64_t> encoded_{0};
  mutable std::mutex mutex_;
  // The mutex guards the following members.
  std::condition_variable wanted_;
  std::map<std::uint32_t, Slot> slots_;  ///< by channel, of those that somebody has subscribed to
  std::uint64_t sequence_{0};
  std::uint32_t last_{0};  ///< channel that was encoded last
  bool stopped_{false};
  std::thread thread_;  ///< from the first request on
};

}  // namespace fuse_flow::stream::foxglove
