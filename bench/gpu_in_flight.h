#pragma once

#include "gpu_frames.h"

#include <algorithm>
#include <array>

namespace bench {

/** \brief One object that always has as many frames in flight as it may. */
class FramesInFlight {
 public:
  FramesInFlight(const Frames& frames, const Route& route, std::size_t lanes,
                 const fuse_flow::FuseFlowParameters& parameters)
      : frames_(frames), route_(route), lanes_(lanes) {
    fusion_.setParameters(parameters);
    fusion_.setFramesInFlight(lanes);
    fusion_.setCopyAhead(route.to_cloud);
  }

  /** \brief Submits a frame, once the oldest has been taken if there is no room for it. visit(number, points, how many) of the
   *  frame that was taken, counted from 0. */
  template <typename Visit>
  void step(const Visit& visit) {
    if (fusion_.inFlight() == lanes_) take(visit);
    fusion_.submit(frames_.at(submitted_++, route_.pageable));
  }
  void step() {
    step([](std::size_t, const Point*, std::size_t) {});
  }

  template <typename Visit>
  void takeAll(const Visit& visit) {
    while (fusion_.inFlight() > 0) take(visit);
  }

 private:
  template <typename Visit>
  void take(const Visit& visit) {
    const std::size_t number = taken_++;
    if (route_.to_cloud) {
      fusion_.next(cloud_);
      visit(number, cloud_.points.data(), cloud_.size());
    } else {
      fusion_.nextPinned([&](const fuse_flow::gpu::PointSpan<Point>& points, std::uint64_t) {
        visit(number, points.points, points.size);
      });
    }
  }

  const Frames& frames_;
  Route route_;
  std::size_t lanes_;
  Gpu fusion_;
  Cloud cloud_;
  std::size_t submitted_{0}, taken_{0};
};

/** \brief Numbers of frames in flight that are tried; the first is the default of FuseFlow. */
constexpr std::array<std::size_t, 5> kLanes{3, 6, 8, 12, 16};

/** \brief Frames a second of a new object, once each of its lanes is warm. */
inline double framesPerSecond(const Frames& frames, const Route& route, std::size_t lanes,
                              const fuse_flow::FuseFlowParameters& parameters, double milliseconds) {
  FramesInFlight flight(frames, route, lanes, parameters);
  for (std::size_t k = 0; k < 3 * lanes; ++k) flight.step();
  std::size_t count = 0;
  const Clock::time_point start = Clock::now();
  for (; count < 2 * lanes || since(start) < milliseconds; ++count) flight.step();
  return 1e3 * static_cast<double>(count) / since(start);
}

/** \brief Frames a second of one route for each number in flight: several runs, each of an object of its own. */
class Rates {
 public:
  void add(std::size_t lane, double rate) { runs_[lane].push_back(rate); }

  double rate(std::size_t lane) const { return median(runs_[lane]); }
  double least(std::size_t lane) const { return *std::min_element(runs_[lane].begin(), runs_[lane].end()); }
  double most(std::size_t lane) const { return *std::max_element(runs_[lane].begin(), runs_[lane].end()); }
  double atDefault() const { return rate(0); }
  /** \brief The place in kLanes of the largest median. */
  std::size_t best() const {
    std::size_t best = 0;
    for (std::size_t lane = 1; lane < kLanes.size(); ++lane)
      if (rate(lane) > rate(best)) best = lane;
    return best;
  }
  double atBest() const { return rate(best()); }
  std::size_t bestLanes() const { return kLanes[best()]; }

 private:
  std::array<std::vector<double>, kLanes.size()> runs_;
};

/** \brief All routes. The rounds are the outermost loop, so that a temporary load of the machine affects one run of each route. */
inline std::array<Rates, kRouteCount> measureRates(const Frames& frames,
                                                   const fuse_flow::FuseFlowParameters& parameters, bool quick) {
  std::array<Rates, kRouteCount> rates;
  for (int round = 0; round < (quick ? 1 : 3); ++round)
    for (std::size_t r = 0; r < kRouteCount; ++r)
      for (std::size_t lane = 0; lane < kLanes.size(); ++lane)
        rates[r].add(lane, framesPerSecond(frames, kRoutes[r], kLanes[lane], parameters, quick ? 50 : 200));
  return rates;
}

}  // namespace bench
