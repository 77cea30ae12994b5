#pragma once

#include "sinks/frame_sink.h"

#include <condition_variable>
#include <deque>
#include <exception>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace fuse_flow::io {

/** \brief Another sink on a thread of its own, which takes the same frames in the same order while the next ones are fused. */
class BackgroundSink : public FrameSink {
 public:
  /** \brief What take() does when as many frames wait as may: it waits, or the frame does not reach the sink, which dropped() counts. */
  enum class WhenFull { Wait, Drop };

  /** \param sink nobody else may use it until finish() has returned  \param waiting how many frames may wait for it; ≥ 1 */
  BackgroundSink(std::shared_ptr<FrameSink> sink, std::size_t waiting, WhenFull when_full = WhenFull::Wait);
  /** \brief Takes all that waits before. */
  ~BackgroundSink() override;
  BackgroundSink(const BackgroundSink&) = delete;
  BackgroundSink& operator=(const BackgroundSink&) = delete;

  /** \throws what the sink has thrown for an earlier frame; it takes none after that */
  void take(const std::shared_ptr<const FusedFrame>& frame) override;
  /** \brief Waits until it has taken all frames. \throws what it has thrown */
  void drain();
  /** \brief Frames that came faster than the sink took them. */
  std::size_t dropped() const;
  /** \brief drain(), and then the sink's. */
  std::vector<std::string> finish() override;

 private:
  void run();

  std::shared_ptr<FrameSink> sink_;
  const std::size_t most_;
  const WhenFull when_full_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  // The mutex guards the following members.
  std::deque<std::shared_ptr<const FusedFrame>> waiting_;
  std::size_t dropped_{0};
  bool working_{false};
  bool ending_{false};
  std::exception_ptr error_;
  std::thread thread_;  // last: it uses the others
};

}  // namespace fuse_flow::io
