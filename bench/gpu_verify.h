#pragma once

#include "gpu_in_flight.h"

#include <cstddef>
#include <cstdio>
#include <cstring>
#include <future>

namespace bench {

/** \brief A number that depends on every bit of every field: of different points it is the same with probability 2⁻⁶⁴. By all
 *  threads, since the frames in flight must not wait for it. */
inline std::uint64_t hashOf(const Point* points, std::size_t count) {
  constexpr std::size_t block = 1 << 14;
  constexpr std::size_t fields = offsetof(Point, view_count) + sizeof(Point::view_count);  // beyond it is padding
  constexpr std::size_t words = (fields + 7) / 8;
  const auto mix = [](std::uint64_t sum, std::uint64_t word) {
    sum = (sum ^ word) * 0x9e3779b97f4a7c15ull;
    return sum ^ sum >> 32;
  };
  std::vector<std::uint64_t> sums((count + block - 1) / block);
  fuse_flow::host::parallelFor(fuse_flow::host::resolveThreads(0), sums.size(), [&](std::size_t b, int) {
    std::uint64_t of_words[words] = {};  // independent of each other, so that one need not wait for another
    for (std::size_t k = b * block; k < std::min(count, (b + 1) * block); ++k) {
      std::uint64_t point[words] = {};
      std::memcpy(point, static_cast<const void*>(points + k), fields);
      for (std::size_t w = 0; w < words; ++w) of_words[w] = mix(of_words[w], point[w]);
    }
    for (const std::uint64_t sum : of_words) sums[b] = mix(sums[b], sum);
  });
  std::uint64_t sum = count;
  for (const std::uint64_t of_block : sums) sum = mix(sum, of_block);
  return sum;
}

struct Comparison {
  std::size_t frames{0}, different{0};

  Comparison& operator+=(const Comparison& other) {
    frames += other.frames;
    different += other.different;
    return *this;
  }
};

/** \brief Frames of one object beside those of the first run, for so long. */
inline Comparison compareInFlight(const Frames& frames, const std::vector<std::uint64_t>& first, const Route& route,
                                  std::size_t lanes, const fuse_flow::FuseFlowParameters& parameters,
                                  double milliseconds) {
  FramesInFlight flight(frames, route, lanes, parameters);
  Comparison result;
  const auto compare = [&](std::size_t number, const Point* points, std::size_t count) {
    ++result.frames;
    if (hashOf(points, count) != first[number % Frames::kCount]) ++result.different;
  };
  const Clock::time_point start = Clock::now();
  for (std::size_t k = 0; k < 4 * lanes || since(start) < milliseconds; ++k) flight.step(compare);
  flight.takeAll(compare);
  return result;
}

/** \brief Whether frames in flight, and those of two objects at once, have the bytes that an object gave which had one frame at a
 *  time. Returns how many have not. */
inline std::size_t verify(const Size& size, const fuse_flow::FuseFlowParameters& parameters, bool quick) {
  const Frames frames(size);
  std::vector<std::uint64_t> first;
  {
    Gpu fusion;
    fusion.setParameters(parameters);
    for (std::size_t k = 0; k < Frames::kCount; ++k) {
      const fuse_flow::gpu::PointSpan<Point> points = fusion.fusePinned(frames.at(k));
      first.push_back(hashOf(points.points, points.size));
    }
  }
  Rates rates;
  for (std::size_t lane = 0; lane < kLanes.size(); ++lane)
    rates.add(lane, framesPerSecond(frames, kRoutes[0], kLanes[lane], parameters, quick ? 50 : 200));
  const std::size_t lanes = rates.bestLanes();
  const double milliseconds = quick ? 200 : 3000;
  Comparison all;
  const auto report = [&](const char* what, std::size_t in_flight, const Comparison& found) {
    std::printf("%s, %s, %zu in flight: %zu frames compared, %zu different\n", size.name().c_str(), what, in_flight,
                found.frames, found.different);
    std::fflush(stdout);
    all += found;
  };
  for (const Route& route : kRoutes)
    report(route.name, lanes, compareInFlight(frames, first, route, lanes, parameters, milliseconds));
  // Half as many each, so that memory that suffices for one object suffices for two.
  const std::size_t half = std::max(kLanes[0], lanes / 2);
  for (const Route& route : kRoutes) {
    auto other = std::async(std::launch::async,
                            [&] { return compareInFlight(frames, first, kRoutes[0], half, parameters, milliseconds); });
    Comparison both = compareInFlight(frames, first, route, half, parameters, milliseconds);
    both += other.get();
    report((std::string("two objects, one of them ") + route.name).c_str(), 2 * half, both);
  }
  std::printf("%s: %zu frames compared with the first run's of the same images, %zu different\n", size.name().c_str(),
              all.frames, all.different);
  return all.different;
}

}  // namespace bench
