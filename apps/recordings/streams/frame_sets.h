#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace fuse_flow::io {

/** \brief A point in time, or a duration, of one clock. */
using Nanoseconds = std::int64_t;

/** \brief The latest time that is taken from a file, in the year 2116: what is later is damage, and sums and differences of two times must be numbers, too. */
constexpr Nanoseconds kLatestTime = (Nanoseconds{1} << 62) - 1;

/** \brief The images of one instant. */
struct FrameSet {
  Nanoseconds stamp{0};   ///< middle between its earliest and its latest image
  Nanoseconds spread{0};  ///< from its earliest to its latest image
  /** \brief images[c] is the number of camera c's image; it has no value if the camera has none of that instant. */
  std::vector<std::optional<std::size_t>> images;
};

/** \brief All instants of a recording. */
struct FrameSets {
  std::vector<FrameSet> sets;       ///< ascending in time
  std::vector<std::size_t> unused;  ///< of each camera, how many images are in no set
  Nanoseconds tolerance{0};         ///< the largest difference between an image and the stamp of its set
};

/** \brief Middle of the differences between neighbours; 0 for fewer than two stamps. \param stamps ascending */
Nanoseconds framePeriod(const std::vector<Nanoseconds>& stamps);

/** \brief Groups the images of several cameras into instants by their time stamps, with the rules of ViewSynchronizer for a shared clock:
 *  the images of a set lie within twice the tolerance, the nearest ones go together, the slowest camera that runs determines the rate, and
 *  where a camera lost a frame, as its period tells, its set is there without it. Since all stamps are known, nothing is lost by waiting: before its first image and behind its last a camera
 *  is not waited for.
 *  \param stamps of each camera, strictly ascending  \param tolerance > 0; absent: half of the shortest period, which fits free-running cameras, too;
 *  without any period, 20 ms */
FrameSets groupByTime(const std::vector<std::vector<Nanoseconds>>& stamps, std::optional<Nanoseconds> tolerance = {});

/** \brief The number of the stamp that is nearest, the earlier of two as near; none if it is further than the tolerance. \param stamps ascending */
std::optional<std::size_t> nearestInTime(const std::vector<Nanoseconds>& stamps, Nanoseconds time,
                                         Nanoseconds tolerance);

}  // namespace fuse_flow::io
