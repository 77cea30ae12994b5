#pragma once

#include <fuse_flow/live/view_synchronizer.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace synchronizer_test {

using namespace std::chrono_literals;
using std::chrono::microseconds;

/** \brief A view on its way: exposed and stamped by its camera, then received by the host. The payload of a view is when it
 *  was truly exposed, µs. */
struct Delivery {
  microseconds arrival;  // the host's time
  std::size_t camera;
  std::uint64_t stamp;
  std::int64_t exposed;
};

using Set = fuse_flow::SynchronizedSet<std::int64_t>;

inline std::size_t viewCount(const Set& set) {
  return static_cast<std::size_t>(
      std::count_if(set.views.begin(), set.views.end(), [](const auto& view) { return view.has_value(); }));
}

/** \brief From the first to the last true exposure in a set. */
inline microseconds trueSpread(const Set& set) {
  std::int64_t first = std::numeric_limits<std::int64_t>::max(), last = std::numeric_limits<std::int64_t>::lowest();
  for (const auto& view : set.views) {
    if (!view) continue;
    first = std::min(first, view->payload);
    last = std::max(last, view->payload);
  }
  return microseconds(last - first);
}

inline fuse_flow::SynchronizerParameters sharedClock() {
  fuse_flow::SynchronizerParameters parameters;
  parameters.clocks = fuse_flow::ClockModel::Shared;
  return parameters;
}

/** \brief A synchroniser whose host time is set by hand. */
struct Host {
  explicit Host(std::size_t cameras, const fuse_flow::SynchronizerParameters& parameters = sharedClock())
      : synchronizer(cameras, parameters, [this] { return now; }) {}

  /** \brief A view that is exposed, stamped and received now. */
  void push(std::size_t camera, microseconds time) {
    synchronizer.push(camera, static_cast<std::uint64_t>(time.count()), time.count());
  }

  /** \brief Receives in the order of arrival, and takes what is ready after each view and every millisecond. */
  std::vector<Set> play(std::vector<Delivery> deliveries) {
    std::stable_sort(deliveries.begin(), deliveries.end(),
                     [](const Delivery& a, const Delivery& b) { return a.arrival < b.arrival; });
    std::vector<Set> sets;
    const auto take_all = [&] {
      while (auto set = synchronizer.take()) sets.push_back(std::move(*set));
    };
    for (const Delivery& delivery : deliveries) {
      for (; now + 1ms <= delivery.arrival; now += 1ms) take_all();
      now = delivery.arrival;
      synchronizer.push(delivery.camera, delivery.stamp, delivery.exposed);
      take_all();
    }
    for (const microseconds end = now + 1s; now < end; now += 1ms) take_all();
    return sets;
  }

  microseconds now{0};
  fuse_flow::ViewSynchronizer<std::int64_t> synchronizer;
};

/** \brief Views at a steady rate, from one time to another, received as they are exposed. */
inline void addStream(std::vector<Delivery>& deliveries, std::size_t camera, microseconds from, microseconds to,
                      microseconds period) {
  for (microseconds t = from; t < to; t += period)
    deliveries.push_back({t, camera, static_cast<std::uint64_t>(t.count()), t.count()});
}

}  // namespace synchronizer_test
