#pragma once

#include <algorithm>
#include <chrono>

namespace fuse_flow::viewing {

/** \brief How often a second something happens: a running mean of the last ten or so, which begins with its first value. */
class RunningRate {
 public:
  /** \brief It has happened once more, so long after the time before. */
  void add(std::chrono::steady_clock::duration since) {
    const double now = 1 / std::max(1e-4, std::chrono::duration<double>(since).count());
    rate_ = rate_ > 0 ? rate_ + 0.1 * (now - rate_) : now;
  }
  double perSecond() const { return rate_; }

 private:
  double rate_{0};
};

}  // namespace fuse_flow::viewing
