#pragma once

#include <cstdint>

namespace fuse_flow {
namespace detail {

/** \brief The usual time between the views of a camera, to tell a frame that it lost from a rate that is low. */
class FramePeriod {
 public:
  /** \param gap µs from the camera's last view to this one  \return frames that should have come between them */
  std::int64_t lostIn(std::int64_t gap) {
    if (period_ > 0 && 2 * gap >= 3 * period_ && ++long_gaps_ < kNewRate) return (gap + period_ / 2) / period_ - 1;
    period_ = period_ > 0 && long_gaps_ < kNewRate ? period_ + (gap - period_) / 8 : gap;  // jitter averages out
    long_gaps_ = 0;
    return 0;
  }

 private:
  static constexpr int kNewRate = 4;  // so many long gaps in a row are no losses
  std::int64_t period_{0};            // µs; 0: not known yet
  int long_gaps_{0};
};

}  // namespace detail
}  // namespace fuse_flow
