#pragma once

#include <fuse_flow/impl/live/wrapping.hpp>

#include <algorithm>
#include <cstdint>

namespace fuse_flow {
namespace detail {

/** \brief Host time minus a camera's time, from the arrival of its views: arrival − stamp is the offset plus a delay that is
 *  never negative, so its running minimum is the offset plus the least delay. The minimum is kept for two halves of the
 *  window, the one that fills and the one before: constant memory, and an offset that grows is followed. */
class ClockOffset {
 public:
  /** \param window µs; > 0, a year at most */
  explicit ClockOffset(std::int64_t window) : half_(std::max<std::int64_t>(1, window / 2)) {}

  void add(std::int64_t arrival, std::int64_t stamp) {
    if (empty_) base_ = wrappingDifference(arrival, stamp);
    const std::int64_t difference = wrappingDifference(wrappingDifference(arrival, stamp), base_);
    const std::int64_t since = wrappingDifference(arrival, began_);
    if (empty_ || since >= 2 * half_) {
      previous_ = current_ = difference;
      began_ = arrival;
      empty_ = false;
    } else if (since >= half_) {
      previous_ = current_;
      current_ = difference;
      began_ = wrappingSum(began_, half_);
    } else {
      current_ = std::min(current_, difference);
    }
  }

  /** \brief The clock was set to another time. */
  void forget() { empty_ = true; }

  /** \brief µs to add to a stamp; 0 before the first view. */
  std::int64_t value() const { return empty_ ? 0 : wrappingSum(base_, std::min(previous_, current_)); }

 private:
  std::int64_t half_;
  std::int64_t began_{0};
  std::int64_t base_{0};  // the first difference; the others are relative to it
  std::int64_t previous_{0};
  std::int64_t current_{0};
  bool empty_{true};
};

}  // namespace detail
}  // namespace fuse_flow
