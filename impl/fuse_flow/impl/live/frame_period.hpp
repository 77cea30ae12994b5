#pragma once

#include <cstdint>

namespace fuse_flow {
namespace detail {

/** \brief The usual time between the views of a camera, to tell a frame that it lost from a rate that is low. */
class FramePeriod {
 public:
  /** \param gap µs from the camera's last view to this one; > 0  \return frames that should have come between them */
  std::int64_t lostIn(std::int64_t gap) {
    const bool is_long = period_ > 0 && gap - period_ >= period_ - period_ / 2;
    if (is_long && ++long_gaps_ < kNewRate) {
      const std::int64_t lost = (gap - (period_ - period_ / 2)) / period_;
      if (is_usual_ || lost < kNewRate) return lost;
      period_ = gap;  // the only gap before it was that of a burst
      long_gaps_ = 0;
      return 0;
    }
    is_usual_ = period_ > 0 && !is_long;
    period_ = is_usual_ ? period_ + (gap - period_) / 8 : gap;  // jitter averages out
    long_gaps_ = 0;
    return 0;
  }

 private:
  static constexpr int kNewRate = 4;  // so many long gaps in a row are no losses
  std::int64_t period_{0};            // µs; 0: not known yet
  bool is_usual_{false};              // more than one gap was like it
  int long_gaps_{0};
};

}  // namespace detail
}  // namespace fuse_flow
