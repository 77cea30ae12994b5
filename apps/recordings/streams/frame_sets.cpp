#include "recordings/streams/frame_sets.h"

#include <algorithm>
#include <limits>

namespace fuse_flow::io {
namespace {

/** \brief An image, or the place of one that the camera lost. */
struct Slot {
  Nanoseconds stamp;
  std::optional<std::size_t> image;
};

/** \brief A camera's images, and where it lost some, the places of those. */
std::vector<Slot> withPlaces(const std::vector<Nanoseconds>& stamps) {
  const Nanoseconds period = framePeriod(stamps);
  // More than these are none: the period is that of a burst, or the recorder was off.
  auto room = static_cast<Nanoseconds>(stamps.size() + 10'000);
  std::vector<Slot> entries;
  for (std::size_t k = 0; k < stamps.size(); ++k) {
    if (k > 0) {
      const Nanoseconds gap = stamps[k] - stamps[k - 1];
      const Nanoseconds lost = (gap + period / 2) / period - 1;
      for (Nanoseconds n = 1; n <= lost && lost <= room; ++n)
        entries.push_back({stamps[k - 1] + gap / (lost + 1) * n, std::nullopt});
      if (lost <= room) room -= lost;
    }
    entries.push_back({stamps[k], k});
  }
  return entries;
}

/** \brief Goes through the entries of all cameras in the order of time. */
class Sweep {
 public:
  Sweep(const std::vector<std::vector<Nanoseconds>>& stamps, Nanoseconds window)
      : window_(window), heads_(stamps.size(), 0), unused_(stamps.size(), 0) {
    for (const auto& camera : stamps) cameras_.push_back(withPlaces(camera));
  }

  std::vector<FrameSet> run() {
    std::vector<FrameSet> sets;
    while (const std::optional<std::size_t> earliest = earliestHead()) {
      if (othersMissing(head(*earliest).stamp) || nextIsNearer(*earliest)) {
        drop(*earliest);
        continue;
      }
      FrameSet set = take(*earliest);
      const auto there = [](const auto& image) { return image.has_value(); };
      if (std::any_of(set.images.begin(), set.images.end(), there)) sets.push_back(std::move(set));
    }
    return sets;
  }

  std::vector<std::size_t> unused() const { return unused_; }

 private:
  bool ended(std::size_t camera) const { return heads_[camera] == cameras_[camera].size(); }
  const Slot& head(std::size_t camera) const { return cameras_[camera][heads_[camera]]; }

  std::optional<std::size_t> earliestHead() const {
    std::optional<std::size_t> earliest;
    for (std::size_t c = 0; c < cameras_.size(); ++c)
      if (!ended(c) && (!earliest || head(c).stamp < head(*earliest).stamp)) earliest = c;
    return earliest;
  }

  bool running(std::size_t camera) const { return heads_[camera] > 0 && !ended(camera); }
  std::optional<Nanoseconds> next(std::size_t camera) const {
    if (heads_[camera] + 1 >= cameras_[camera].size()) return std::nullopt;
    return cameras_[camera][heads_[camera] + 1].stamp;
  }

  /** \brief Whether a camera that runs has nothing within the window: it is slower than the one whose slot this is. */
  bool othersMissing(Nanoseconds from) const {
    for (std::size_t c = 0; c < cameras_.size(); ++c)
      if (running(c) && head(c).stamp - from > window_) return true;
    return false;
  }

  /** \brief Whether a camera's head may go with the earliest one. What another camera begins with waits for the nearest one. */
  bool goesWith(std::size_t camera, std::size_t earliest) const {
    if (ended(camera)) return false;
    const Nanoseconds from = head(earliest).stamp, stamp = head(camera).stamp;
    if (stamp - from > window_) return false;
    return running(camera) || !next(earliest) || stamp - from <= std::abs(*next(earliest) - stamp);
  }

  /** \brief Whether a set with the camera's next slot in place of its head is as full, and less spread by a quarter: two cameras half a
   *  period apart, whose stamps jitter, must not change their partners all the time. */
  bool nextIsNearer(std::size_t camera) const {
    if (!next(camera)) return false;
    const Nanoseconds from = head(camera).stamp;
    Nanoseconds first = std::numeric_limits<Nanoseconds>::max(), last = from;  // of the others
    for (std::size_t c = 0; c < cameras_.size(); ++c) {
      if (c == camera || !goesWith(c, camera)) continue;
      first = std::min(first, head(c).stamp);
      last = std::max(last, head(c).stamp);
    }
    if (first > last) return false;  // it is alone
    return std::max(*next(camera), last) - std::min(*next(camera), first) < (last - from) / 4 * 3;
  }

  void drop(std::size_t camera) {
    unused_[camera] += head(camera).image ? 1 : 0;
    ++heads_[camera];
  }

  FrameSet take(std::size_t earliest) {
    std::vector<std::size_t> members;
    for (std::size_t c = 0; c < cameras_.size(); ++c)
      if (goesWith(c, earliest)) members.push_back(c);
    FrameSet set;
    set.images.resize(cameras_.size());
    const Nanoseconds from = head(earliest).stamp;
    Nanoseconds last = from, first_image = std::numeric_limits<Nanoseconds>::max(), last_image = from;
    for (const std::size_t c : members) {
      const Slot& slot = head(c);
      last = std::max(last, slot.stamp);
      if (slot.image) {
        first_image = std::min(first_image, slot.stamp);
        last_image = std::max(last_image, slot.stamp);
      }
      set.images[c] = slot.image;
      ++heads_[c];
    }
    set.stamp = from + (last - from) / 2;
    set.spread = std::max<Nanoseconds>(0, last_image - first_image);
    return set;
  }

  Nanoseconds window_;
  std::vector<std::vector<Slot>> cameras_;
  std::vector<std::size_t> heads_;
  std::vector<std::size_t> unused_;
};

/** \brief Half of the shortest period. */
Nanoseconds usualTolerance(const std::vector<std::vector<Nanoseconds>>& stamps) {
  constexpr Nanoseconds without_period = 20'000'000;
  Nanoseconds shortest = 0;
  for (const auto& camera : stamps)
    if (const Nanoseconds period = framePeriod(camera); period > 0)
      shortest = shortest == 0 ? period : std::min(shortest, period);
  return shortest == 0 ? without_period : std::max<Nanoseconds>(1, shortest / 2);
}

}  // namespace

Nanoseconds framePeriod(const std::vector<Nanoseconds>& stamps) {
  if (stamps.size() < 2) return 0;
  std::vector<Nanoseconds> gaps;
  for (std::size_t k = 1; k < stamps.size(); ++k) gaps.push_back(stamps[k] - stamps[k - 1]);
  const auto middle = gaps.begin() + static_cast<std::ptrdiff_t>((gaps.size() - 1) / 2);
  std::nth_element(gaps.begin(), middle, gaps.end());
  return *middle;
}

FrameSets groupByTime(const std::vector<std::vector<Nanoseconds>>& stamps, std::optional<Nanoseconds> tolerance) {
  FrameSets result;
  result.tolerance = tolerance.value_or(usualTolerance(stamps));
  Sweep sweep(stamps, 2 * result.tolerance);
  result.sets = sweep.run();
  result.unused = sweep.unused();
  return result;
}

std::optional<std::size_t> nearestInTime(const std::vector<Nanoseconds>& stamps, Nanoseconds time,
                                         Nanoseconds tolerance) {
  auto best = std::lower_bound(stamps.begin(), stamps.end(), time);
  if (best != stamps.begin() && (best == stamps.end() || time - *(best - 1) <= *best - time)) --best;
  if (best == stamps.end() || std::abs(*best - time) > tolerance) return std::nullopt;
  return static_cast<std::size_t>(best - stamps.begin());
}

}  // namespace fuse_flow::io
