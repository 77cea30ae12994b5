#pragma once

#include <fuse_flow/impl/live/wrapping.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <tuple>
#include <vector>

namespace fuse_flow {
namespace detail {

/** \brief The position of a camera that has no view in a set. */
constexpr std::size_t kNoView = std::numeric_limits<std::size_t>::max();

/** \brief For each camera the times of its views, oldest first. */
using ViewTimes = std::vector<std::vector<std::int64_t>>;

/** \brief The earliest and the latest time of a set that is not empty. */
struct TimeRange {
  std::int64_t earliest{std::numeric_limits<std::int64_t>::max()};
  std::int64_t latest{std::numeric_limits<std::int64_t>::lowest()};

  TimeRange(const ViewTimes& times, const std::vector<std::size_t>& chosen) {
    for (std::size_t c = 0; c < times.size(); ++c) {
      if (chosen[c] == kNoView) continue;
      earliest = std::min(earliest, times[c][chosen[c]]);
      latest = std::max(latest, times[c][chosen[c]]);
    }
  }
  std::int64_t spread() const { return latest - earliest; }
  std::int64_t middle() const { return earliest + spread() / 2; }
};

/** \brief The cameras of a set, each with its view that is nearest to a time. */
inline std::vector<std::size_t> nearestTo(std::int64_t time, const ViewTimes& times, std::vector<std::size_t> chosen) {
  for (std::size_t c = 0; c < times.size(); ++c) {
    if (chosen[c] == kNoView) continue;
    for (std::size_t k = 0; k < times[c].size(); ++k)
      if (distance(times[c][k], time) < distance(times[c][chosen[c]], time)) chosen[c] = k;
  }
  return chosen;
}

/** \brief Of the windows no longer than max_spread those with views of the most cameras, and the latest of them: which view
 *  of each camera lies in it. Any order of views and cameras gives the same. */
inline std::vector<std::size_t> fullestSet(const ViewTimes& times, std::uint64_t max_spread) {
  struct Candidate {
    std::int64_t time;
    std::size_t camera, position;
    bool operator<(const Candidate& o) const {
      return std::tie(o.time, camera, o.position) < std::tie(time, o.camera, position);  // latest first
    }
  };
  std::vector<Candidate> candidates;
  for (std::size_t c = 0; c < times.size(); ++c)
    for (std::size_t k = 0; k < times[c].size(); ++k) candidates.push_back({times[c][k], c, k});
  std::sort(candidates.begin(), candidates.end());

  std::vector<int> views(times.size(), 0);  // in the window from latest to behind, which slides towards the past
  std::size_t cameras = 0, most = 0, best = 0, behind = 0;
  for (std::size_t latest = 0; latest < candidates.size(); ++latest) {
    for (; behind < candidates.size() && distance(candidates[latest].time, candidates[behind].time) <= max_spread;
         ++behind)
      if (views[candidates[behind].camera]++ == 0) ++cameras;
    if (cameras > most) {
      most = cameras;
      best = latest;
    }
    if (--views[candidates[latest].camera] == 0) --cameras;
  }

  std::vector<std::size_t> chosen(times.size(), kNoView);
  for (std::size_t k = best; k < candidates.size() && distance(candidates[best].time, candidates[k].time) <= max_spread;
       ++k)
    if (chosen[candidates[k].camera] == kNoView) chosen[candidates[k].camera] = candidates[k].position;
  if (most == 0) return chosen;
  // The camera that is behind the others may belong to their previous views rather than to these.
  const TimeRange range(times, chosen);
  const std::vector<std::size_t> around_earliest = nearestTo(range.earliest, times, chosen);
  return TimeRange(times, around_earliest).spread() < range.spread() ? around_earliest : chosen;
}

}  // namespace detail
}  // namespace fuse_flow
