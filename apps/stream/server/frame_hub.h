#pragma once

#include "stream/server/pace.h"
#include "stream/server/session.h"

#include <fuse_flow/stream/server.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace fuse_flow::stream::network {

/** \brief Steps that clients can have: the server's, twice, four times and eight times that. */
constexpr std::size_t kSteps = 4;

/** \brief A frame, in the steps in which somebody wants it. */
struct PublishedFrame {
  std::uint64_t sequence{0};  ///< 1, 2, 3, … of this server, whatever the frames' own numbers are
  Clock::time_point when;
  std::array<std::shared_ptr<const EncodedFrame>, kSteps> of_step;  ///< null: nobody wanted it
  bool from_cloud{false};

  /** \brief The nearest that there is, rather the coarser one. */
  std::shared_ptr<const EncodedFrame> nearest(std::size_t step) const;
};

/** \brief A client, as all may see it. */
struct Member {
  explicit Member(std::weak_ptr<Channel> to) : channel(std::move(to)) {}

  const std::weak_ptr<Channel> channel;
  const Clock::time_point since{Clock::now()};
  std::atomic<std::uint64_t> sending{0};  ///< PublishedFrame::sequence of what is on its way to the kernel; 0: nothing
  std::atomic<std::size_t> sending_bytes{0};  ///< of the whole frame, which is held until then
  /** \brief If it is no frame but an image, which was chosen while that was the newest frame: the image's own sequence, else 0. */
  std::atomic<std::uint64_t> sending_image{0};
  std::atomic<std::size_t> step{0};  ///< that it wants, 0 … kSteps − 1
  std::atomic<bool> watching{true};  ///< false: it wants no frames
  std::mutex mutex;
  ClientReport report;  ///< guarded by the mutex
};

/** \brief The newest frame, and who gets it. Many threads may use it. It never waits for a client. */
class FrameHub {
 public:
  /** \param held_bytes see ServerOptions  \param step metres, of step 0 */
  FrameHub(std::size_t held_bytes, double step) : held_bytes_(held_bytes), step_(step) {}

  std::shared_ptr<Member> join(std::weak_ptr<Channel> channel, std::string subprotocol, bool watching = true);
  void leave(const std::shared_ptr<Member>& member);

  /** \brief Sets sequence and when, and wakes all. */
  void publish(PublishedFrame frame);
  void describe(std::string json);
  /** \brief Wakes all. */
  void wake() { wakeAll(copyOfMembers()); }
  /** \brief Says good-bye to all. */
  void goAway();

  std::shared_ptr<const PublishedFrame> latest() const;
  /** \brief The description as JSON, and how often it has changed. */
  std::pair<std::shared_ptr<const std::string>, std::uint64_t> description() const;
  /** \brief From frame to frame, as they come; from 5 ms to 1 s. */
  Clock::duration interval() const;
  std::uint64_t published() const;
  /** \brief In metres: what the wish of a client for a step becomes, 0 … kSteps − 1. */
  std::size_t stepFor(double wished) const;

  std::size_t members() const;
  /** \brief Those that want frames. */
  std::size_t watchers() const;
  /** \brief Of each step, how many want it. */
  std::array<std::size_t, kSteps> wanted() const;
  std::vector<ClientReport> reports() const;
  /** \brief Ends those that hold the oldest frames, where the frames that are held, but for the newest, are more than held_bytes.
   *  \return how many */
  std::size_t shed();

 private:
  static void wakeAll(const std::vector<std::shared_ptr<Member>>& members);
  std::vector<std::shared_ptr<Member>> copyOfMembers() const;

  const std::size_t held_bytes_;
  const double step_;
  mutable std::mutex mutex_;
  // The mutex guards the following members.
  std::list<std::shared_ptr<Member>> members_;
  std::shared_ptr<const PublishedFrame> latest_;
  std::uint64_t published_{0};
  Clock::duration interval_{std::chrono::seconds(1)};
  std::shared_ptr<const std::string> description_{std::make_shared<std::string>()};
  std::uint64_t descriptions_{0};
};

}  // namespace fuse_flow::stream::network
