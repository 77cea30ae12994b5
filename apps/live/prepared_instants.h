#pragma once

#include "live/live_rig.h"

#include <chrono>
#include <condition_variable>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

namespace fuse_flow::io {

/** \brief The instants of a rig, each prepared on a thread of its own while the one before it is fused: as many a second as the slower of the two
 *  allows. At most one instant is prepared, or being prepared, that nobody has taken; the one that it begins with is the latest. All that came before
 *  the rig ended are worth preparing. next() is for one thread. */
class PreparedInstants {
 public:
  using Prepare = std::function<void(LiveInstant&)>;

  /** \param rig must stay; nobody else asks it for instants  \param prepare is called on the thread */
  PreparedInstants(LiveRig& rig, Prepare prepare);
  /** \brief Ends after the instant at hand. */
  ~PreparedInstants();
  PreparedInstants(const PreparedInstants&) = delete;
  PreparedInstants& operator=(const PreparedInstants&) = delete;

  /** \brief The next instant; null: none was ready in that time. Must not be called again after it has thrown.
   *  \throws what LiveRig::running(), LiveRig::next() or preparing threw */
  std::shared_ptr<LiveInstant> next(std::chrono::milliseconds timeout);
  /** \brief False: no instant will come any more, as with LiveRig::running(). */
  bool running() const;

 private:
  void run();
  bool prepareNext();
  bool ending() const;

  LiveRig& rig_;
  const Prepare prepare_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  // The mutex guards the following members.
  std::shared_ptr<LiveInstant> ready_;
  std::exception_ptr error_;
  bool ended_{false};  ///< the thread
  bool ending_{false};
  std::thread thread_;  ///< the last, as it uses the others
};

}  // namespace fuse_flow::io
