#include "recordings/streams/time_matching.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>

namespace fuse_flow::io {
namespace {

std::string milliseconds(Nanoseconds time) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f ms", static_cast<double>(time) * 1e-6);
  return text;
}

constexpr Nanoseconds kSeen = 5'000'000;  // a hand at 2 m/s is 10 mm further

Nanoseconds middleOf(std::vector<Nanoseconds>& times) {
  const auto middle = times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2);
  std::nth_element(times.begin(), middle, times.end());
  return *middle;
}

/** \brief What moves stands elsewhere for each camera of a set. */
void warnOfSpread(const FrameSets& grouped, std::vector<std::string>& warnings) {
  std::vector<Nanoseconds> spreads;
  for (const FrameSet& set : grouped.sets)
    if (countImages(set) > 1) spreads.push_back(set.spread);
  if (spreads.empty()) return;
  if (const Nanoseconds middle = middleOf(spreads); middle > kSeen)
    warnings.push_back(
        "the cameras' images of one frame are taken within " + milliseconds(middle) +
        " (median), so that what moves may be double; cameras that expose together have them within 1 ms");
}

/** \brief Clocks that do not belong together give sets of one camera each. */
void warnOfStrangers(const FrameSets& grouped, const std::vector<CameraTimes>& cameras,
                     std::vector<std::string>& warnings) {
  std::vector<const CameraTimes*> some;
  for (const CameraTimes& camera : cameras)
    if (!camera.stamps.empty()) some.push_back(&camera);
  const auto shared = [](const FrameSet& set) { return countImages(set) > 1; };
  if (some.size() < 2 || std::any_of(grouped.sets.begin(), grouped.sets.end(), shared)) return;
  warnings.push_back("no two cameras have images of the same time: the stamps of " + some[0]->file + " begin at " +
                     std::to_string(some[0]->begins) + " ns, those of '" + some[1]->camera + "' at " +
                     std::to_string(some[1]->begins) + " ns; they must be of one clock");
}

}  // namespace

std::vector<Nanoseconds> ascendingStamps(const std::string& track, const std::vector<Nanoseconds>& stamps,
                                         std::vector<std::size_t>& kept, std::vector<std::string>& warnings) {
  std::vector<Nanoseconds> ascending;
  std::optional<std::size_t> first_back;
  kept.clear();
  for (std::size_t k = 0; k < stamps.size(); ++k) {
    if (ascending.empty() || stamps[k] > ascending.back()) {
      ascending.push_back(stamps[k]);
      kept.push_back(k);
    } else if (!first_back) {
      first_back = k;
    }
  }
  if (first_back)
    warnings.push_back(
        track + ": " + std::to_string(stamps.size() - kept.size()) + " of " + std::to_string(stamps.size()) +
        " images have a time stamp that is not later than those before, and are left out; the first is "
        "image " +
        std::to_string(*first_back) + ", " + milliseconds(stamps[*first_back - 1] - stamps[*first_back]) + " back");
  return ascending;
}

std::size_t countImages(const FrameSet& set) {
  return static_cast<std::size_t>(
      std::count_if(set.images.begin(), set.images.end(), [](const auto& image) { return image.has_value(); }));
}

FrameSets framesByTime(const std::vector<CameraTimes>& cameras, std::vector<std::string>& warnings) {
  std::vector<std::vector<Nanoseconds>> stamps;
  for (const CameraTimes& camera : cameras) stamps.push_back(camera.stamps);
  FrameSets grouped = groupByTime(stamps);
  for (std::size_t c = 0; c < cameras.size(); ++c)
    if (grouped.unused[c] > 0)
      warnings.push_back("camera '" + cameras[c].camera + "': " + std::to_string(grouped.unused[c]) + " of " +
                         std::to_string(stamps[c].size()) + " images have no partner within " +
                         milliseconds(2 * grouped.tolerance) + ", and are left out; the slowest camera sets the rate");
  warnOfStrangers(grouped, cameras, warnings);
  warnOfSpread(grouped, warnings);
  return grouped;
}

std::vector<std::optional<std::size_t>> colorByTime(const std::string& camera, const std::vector<Nanoseconds>& depth,
                                                    const std::vector<Nanoseconds>& color, Nanoseconds delay,
                                                    std::vector<std::string>& warnings) {
  const Nanoseconds period = std::max(framePeriod(depth), framePeriod(color));
  constexpr Nanoseconds without_period = 20'000'000;
  std::vector<std::optional<std::size_t>> matches;
  std::size_t without = 0;
  std::vector<Nanoseconds> apart;
  for (const Nanoseconds stamp : depth) {
    const Nanoseconds time = stamp - delay;
    matches.push_back(nearestInTime(color, time, period > 0 ? period / 2 : without_period));
    if (matches.back())
      apart.push_back(std::abs(color[*matches.back()] - time));
    else
      ++without;
  }
  const std::string name = "camera '" + camera + "': ";
  if (without > 0)
    warnings.push_back(name + std::to_string(without) + " of " + std::to_string(depth.size()) +
                       " depth images have no colour image of their time, and give points without colour");
  if (apart.empty()) return matches;
  if (const Nanoseconds middle = middleOf(apart); middle > kSeen)
    warnings.push_back(name + "its colour images are taken " + milliseconds(middle) +
                       " before or after depth (median), so that what moves gets the colour of what is beside it");
  return matches;
}

}  // namespace fuse_flow::io
