// What ViewSynchronizer makes of a minute of simulated cameras: the table in doc/notes/live.md. Host time is simulated too, so that
// every machine gets the same numbers; only the last column is this machine's.
#include "evaluation/tables/markdown.h"

#include <fuse_flow/live/view_synchronizer.h>

#include <algorithm>
#include <iostream>
#include <random>
#include <tuple>

namespace {

using namespace fuse_flow;
using std::chrono::microseconds;

constexpr std::int64_t kSecond = 1000000;  // µs
constexpr std::int64_t kEnd = 60 * kSecond;

struct Camera {
  double rate{30};                              // Hz
  std::int64_t phase{0};                        // µs after the others'
  std::pair<int, int> delay{5000, 15000};       // from exposure to arrival, µs
  double drift{0};                              // µs per second
  double lost{0};                               // share of its frames
  std::int64_t stalls_from{kEnd}, until{kEnd};  // µs
};

struct Scenario {
  std::string name;
  std::vector<Camera> cameras;
  microseconds tolerance{8000};
};

struct Delivery {
  std::int64_t arrival;
  std::size_t camera;
  std::int64_t stamp, exposed;
};

std::vector<Delivery> deliveriesOf(const std::vector<Camera>& cameras) {
  std::vector<Delivery> deliveries;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> chance(0, 1);
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    const Camera& camera = cameras[c];
    std::uniform_int_distribution<int> delay(camera.delay.first, camera.delay.second);
    const std::int64_t started = static_cast<std::int64_t>(c) * 1000 * kSecond;  // each clock began at another time
    std::int64_t before = 0;
    for (std::int64_t frame = 0;; ++frame) {
      const std::int64_t exposed =
          camera.phase + static_cast<std::int64_t>(1e6 * static_cast<double>(frame) / camera.rate);
      if (exposed >= kEnd) break;
      if (chance(random) < camera.lost || (exposed >= camera.stalls_from && exposed < camera.until)) continue;
      const auto gained = static_cast<std::int64_t>(camera.drift * 1e-6 * static_cast<double>(exposed));
      before = std::max(before + 1, exposed + delay(random));  // a camera delivers in order
      deliveries.push_back({before, c, started + exposed + gained, exposed});
    }
  }
  std::sort(deliveries.begin(), deliveries.end(), [](const Delivery& a, const Delivery& b) {
    return std::tie(a.arrival, a.camera) < std::tie(b.arrival, b.camera);
  });
  return deliveries;
}

/** \brief Microseconds, printed in milliseconds. */
class Figure {
 public:
  void add(std::int64_t value) { values_.push_back(value); }
  /** \brief "median, 99 of 100, largest" */
  std::string text() {
    std::sort(values_.begin(), values_.end());
    const auto text = [&](std::size_t percent) {
      return tables::number(1e-3 * static_cast<double>(values_[percent * (values_.size() - 1) / 100]), 1);
    };
    return text(50) + ", " + text(99) + ", " + text(100);
  }

 private:
  std::vector<std::int64_t> values_;
};

void measure(const Scenario& scenario, tables::MarkdownTable& table) {
  const std::vector<Delivery> deliveries = deliveriesOf(scenario.cameras);
  SynchronizerParameters parameters;
  parameters.tolerance = scenario.tolerance;
  std::int64_t now = 0;
  ViewSynchronizer<std::int64_t> synchronizer(scenario.cameras.size(), parameters,
                                              [&now] { return microseconds(now); });
  Figure spread, latency;
  std::int64_t last_set = 0, longest_gap = 0;
  const auto take = [&] {
    while (const auto set = synchronizer.take()) {
      std::int64_t first = kEnd, last = 0;
      for (const auto& view : set->views) {
        if (!view) continue;
        first = std::min(first, view->payload);
        last = std::max(last, view->payload);
      }
      spread.add(last - first);
      latency.add(now - last);
      longest_gap = std::max(longest_gap, now - last_set);
      last_set = now;
    }
  };
  const auto start = std::chrono::steady_clock::now();
  for (const Delivery& delivery : deliveries) {
    for (; now + 1000 <= delivery.arrival; now += 1000) take();
    now = delivery.arrival;
    synchronizer.push(delivery.camera, static_cast<std::uint64_t>(delivery.stamp), delivery.exposed);
    take();
  }
  const std::chrono::duration<double, std::micro> elapsed = std::chrono::steady_clock::now() - start;

  const SynchronizerStatistics statistics = synchronizer.getStatistics();
  std::uint64_t used = 0;
  for (const auto& camera : statistics.cameras) used += camera.used;
  longest_gap = std::max(longest_gap, kEnd - last_set);
  const auto sets = static_cast<double>(statistics.complete_sets + statistics.incomplete_sets);
  const auto views = static_cast<double>(deliveries.size());
  table.row({scenario.name, tables::number(views / 60, 1), tables::number(sets / 60, 1),
             tables::number(100 * static_cast<double>(statistics.complete_sets) / sets, 1) + " %",
             tables::number(100 * (1 - static_cast<double>(used) / views), 1) + " %", spread.text(), latency.text(),
             tables::number(1e-3 * static_cast<double>(longest_gap), 1), tables::number(elapsed.count() / views, 2)});
}

std::vector<Scenario> scenarios() {
  std::vector<Scenario> result{
      {"4 × 30 Hz, triggered", std::vector<Camera>(4)},
      {"8 × 30 Hz, triggered, clocks drift by up to 100 µs/s, delays of 5 to 40 ms", std::vector<Camera>(8)},
      {"6 × 30 Hz, free-running, tolerance 17 ms", std::vector<Camera>(6), microseconds(17000)},
      {"60, 60, 30, 30 and 15 Hz", std::vector<Camera>(5)},
      {"4 × 30 Hz, each loses 2 % of its frames", std::vector<Camera>(4)},
      {"4 × 30 Hz, one stalls from 20 to 40 s", std::vector<Camera>(4)},
      {"64 × 30 Hz, triggered", std::vector<Camera>(64)},
      {"64 × 30 Hz, each loses 10 % of its frames, delays of 5 to 55 ms", std::vector<Camera>(64)}};
  for (std::size_t c = 0; c < 8; ++c) {
    result[1].cameras[c].drift = -100 + 200.0 * static_cast<double>(c) / 7;
    result[1].cameras[c].delay = {5000, 40000};
  }
  for (std::size_t c = 0; c < 6; ++c) result[2].cameras[c].phase = static_cast<std::int64_t>(c * 12345 % 33333);
  for (const std::size_t c : {0u, 1u}) result[3].cameras[c].rate = 60;
  result[3].cameras[4].rate = 15;
  for (Camera& camera : result[4].cameras) camera.lost = 0.02;
  result[5].cameras[3].stalls_from = 20 * kSecond;
  result[5].cameras[3].until = 40 * kSecond;
  for (Camera& camera : result[7].cameras) {
    camera.lost = 0.1;
    camera.delay = {5000, 55000};
  }
  return result;
}

}  // namespace

int main() {
  tables::MarkdownTable table({"cameras, each with a clock of its own", "views in, 1/s", "sets out, 1/s", "complete",
                               "views dropped", "true spread: median, 99 %, largest, ms",
                               "latency: median, 99 %, largest, ms", "longest time without a set, ms",
                               "cost, µs a view"});
  for (const Scenario& scenario : scenarios()) measure(scenario, table);
  std::cout << table.text();
  return 0;
}
