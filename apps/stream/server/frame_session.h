#pragma once

#include "stream/server/frame_hub.h"
#include "stream/server/gate.h"
#include "stream/server/pace.h"
#include "stream/server/session.h"

#include <fuse_flow/stream/encoded_frame.h>

#include <chrono>
#include <deque>
#include <memory>
#include <string>

namespace fuse_flow::stream::network {

constexpr const char* kSubprotocol = "fuse_flow.v1";

/** \brief A client of fuse_flow.v1, see doc/reference/stream_format.md.
 *
 *  What is on its way to a client is at most two frames: one is sent while one is unanswered. The next one is chosen only when it can be
 *  sent, and is the newest then, so nothing waits and nothing is old. */
class FrameSession : public Session {
 public:
  /** \param answer_time see ServerOptions */
  FrameSession(const std::shared_ptr<Channel>& channel, std::shared_ptr<FrameHub> hub, Gate& gate,
               std::chrono::milliseconds answer_time);

  void opened() override;
  void received(std::string_view message, bool binary) override;
  void sent() override;
  void pong(std::chrono::steady_clock::duration round_trip) override;
  void woken() override;
  void closed() override;

 private:
  struct Unanswered {
    std::uint64_t number;
    std::size_t bytes;
    Clock::time_point sent;
  };

  void answered(std::uint64_t number);
  void setWishes(const Wishes& wishes);
  /** \brief Sends what there is to send, if it can be sent now. */
  void look();
  /** \brief The frame again, with more points: it is limited, no other has come for a while, and the client has time. */
  bool canRefine(const PublishedFrame& frame, Clock::time_point now) const;
  void sendFrame(const PublishedFrame& frame, Clock::time_point now, bool refines);
  /** \brief Ends it, with a notice. */
  void refuse(const std::string& reason);
  /** \brief Ends it if it has not answered for too long. */
  bool overdue(Clock::time_point now);

  Channel& channel_;  // which owns this
  const std::weak_ptr<Channel> shared_channel_;
  const std::shared_ptr<FrameHub> hub_;
  Gate& gate_;
  const Clock::duration answer_time_;
  std::shared_ptr<Member> member_;
  Pace pace_;
  Wishes wishes_;
  std::deque<Unanswered> unanswered_;
  std::uint64_t described_{0};  ///< which description it has
  std::uint64_t sequence_{0};   ///< of the frame that was sent last
  std::size_t bytes_{0};        ///< of that
  bool limited_{false};         ///< by its pace
  bool again_{false};           ///< the frame is to be sent again, as wishes have changed
  bool sending_{false}, ended_{false};
  Clock::time_point heard_, pinged_, last_answer_;
  Clock::time_point next_look_;  ///< when it looks for what is overdue
  Clock::time_point earliest_;   ///< the next frame does not go before
};

}  // namespace fuse_flow::stream::network
