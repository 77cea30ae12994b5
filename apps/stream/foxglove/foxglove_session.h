#pragma once

#include "stream/foxglove/client_requests.h"
#include "stream/foxglove/feed.h"
#include "stream/server/frame_hub.h"
#include "stream/server/gate.h"
#include "stream/server/pace.h"
#include "stream/server/session.h"

#include <chrono>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace fuse_flow::stream::foxglove {

/** \brief What Foxglove and Lichtblick ask for. The second is of the programs that Foxglove's newer library is in; what is used of it here is
 *  the same. */
constexpr const char* kSubprotocols[] = {"foxglove.websocket.v1", "foxglove.sdk.v1"};

/** \brief A client of Foxglove's WebSocket protocol, version 1.
 *
 *  The protocol has no message that says that a frame has arrived. But a ping comes after the frame that was sent before it, and every
 *  WebSocket answers it: so a pong is taken for that. As in fuse_flow.v1, at most two frames are on their way to a client, and each is the
 *  newest when it is chosen; a client that is slower than frames are made gets fewer layers of them. Of each camera whose images it wants,
 *  likewise two; channels take turns, and what images take is missing from what clouds get. */
class FoxgloveSession : public network::Session {
 public:
  /** \param answer_time see ServerOptions */
  FoxgloveSession(const std::shared_ptr<network::Channel>& channel, std::shared_ptr<network::FrameHub> hub,
                  std::shared_ptr<Feed> feed, network::Gate& gate, std::chrono::milliseconds answer_time,
                  std::string subprotocol);

  void opened() override;
  void received(std::string_view message, bool binary) override;
  void sent() override;
  void pong(std::chrono::steady_clock::duration round_trip) override;
  void woken() override;
  void closed() override;

 private:
  using Clock = network::Clock;

  /** \brief To a channel. */
  struct Subscription {
    std::uint32_t id{0};
    std::uint64_t version{0};    ///< of the message that was sent last, see Topic; 0: none
    bool images{false};          ///< it is to a camera's images
    std::uint64_t sequence{0};   ///< of the image that was sent last; 0: none
    std::uint64_t waits_for{0};  ///< see ImageFeed::request()
  };
  struct Unanswered {
    std::uint32_t channel;
    std::size_t bytes;
    Clock::time_point sent;
  };

  void subscribe(const Subscribe& request);
  void unsubscribe(const Unsubscribe& request);
  void leave(std::uint32_t channel);
  void say(int level, const std::string& text);

  /** \brief Sends what there is to send, if it can be sent now. */
  void look();
  void send(std::string text);
  bool sendChannels();
  bool sendMessage();
  /** \brief A cloud or an image, of that channel whose turn it is. */
  void sendNext();
  void sendNextCloud();
  void sendNextImage(std::uint32_t channel, Subscription& subscription);
  /** \brief Until the first one is answered nothing is known of the client, and a second would double a mistake. */
  bool mayFollow(std::uint32_t channel) const;
  std::size_t unanswered(std::uint32_t channel) const;
  /** \brief What Channel::send() is called for next is a cloud or an image. \param held bytes that stay in memory until it is out
   *  \param image its sequence, if it is one */
  void beginCounted(std::uint32_t channel, std::size_t bytes, std::uint64_t sequence, std::size_t held,
                    std::uint64_t image);
  /** \param time that the client has for it  \param refines it has the frame, but not all points */
  void sendCloud(const std::shared_ptr<const CloudPayload>& payload, Clock::duration time, bool refines);
  void ping();
  /** \brief Ends it, with a notice. */
  void refuse(const std::string& reason);
  /** \brief Ends it if it has not answered for too long. */
  bool overdue(Clock::time_point now);

  network::Channel& channel_;  // which owns this
  const std::weak_ptr<network::Channel> shared_channel_;
  const std::shared_ptr<network::FrameHub> hub_;
  const std::shared_ptr<Feed> feed_;
  network::Gate& gate_;
  const Clock::duration answer_time_;
  const std::string subprotocol_;
  std::shared_ptr<network::Member> member_;
  network::Pace pace_;

  std::shared_ptr<const Channels> channels_;    ///< that it was told of; null: nothing yet
  std::shared_ptr<const Channels> being_told_;  ///< of which it was told what is no more there, and not yet what is new
  std::map<std::uint32_t, Subscription> of_channels_;  ///< by channel
  std::map<std::uint32_t, std::uint32_t> channel_of_;  ///< of a subscription
  std::deque<std::string> statuses_;                   ///< that wait

  std::uint64_t requested_{0};    ///< frame that the feed makes for it; 0: none
  std::uint64_t sequence_{0};     ///< of the frame that was sent last; 0: none since it has subscribed
  std::size_t layers_{0};         ///< of that
  bool limited_{false};           ///< by its pace
  std::size_t image_bytes_{0};    ///< that were sent since the last cloud
  Clock::time_point cloud_sent_;  ///< the last one; none yet: long ago
  std::uint32_t last_served_{0};  ///< channel
  std::deque<Unanswered> unanswered_;
  std::size_t handed_over_{0};  ///< of them, the first so many are out
  std::size_t pinged_for_{0};   ///< and so many are answered by the pong that is awaited
  bool pinging_{false}, sending_{false}, sending_counted_{false}, ended_{false};
  Clock::time_point heard_, pinged_, last_answer_;
};

}  // namespace fuse_flow::stream::foxglove
