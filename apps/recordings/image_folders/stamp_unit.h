#pragma once

#include "recordings/streams/frame_sets.h"

#include <cmath>
#include <optional>

namespace fuse_flow::io {

/** \brief The unit of time stamps that are text, in lists and in names of files. */
struct StampUnit {
  long double nanoseconds;
  const char* name;  ///< "seconds"
};

/** \brief From here on a number is a time in ms, µs or ns since 1970. No recording has as many frames. */
constexpr long double kLeastStamp = 1e11L;

/** \brief One unit for all stamps of a list, recognised by the size of the largest: a date in this century, or seconds since a start. */
inline StampUnit stampUnit(long double largest) {
  if (largest < kLeastStamp) return {1e9L, "seconds"};
  if (largest < 1e14L) return {1e6L, "milliseconds"};
  if (largest < 1e17L) return {1e3L, "microseconds"};
  return {1.0L, "nanoseconds"};
}

/** \brief None for what is no time in this unit: negative, or later than kLatestTime. */
inline std::optional<Nanoseconds> inNanoseconds(long double stamp, const StampUnit& unit) {
  if (!(stamp >= 0 && stamp * unit.nanoseconds <= kLatestTime)) return std::nullopt;
  return static_cast<Nanoseconds>(std::llround(stamp * unit.nanoseconds));
}

}  // namespace fuse_flow::io
