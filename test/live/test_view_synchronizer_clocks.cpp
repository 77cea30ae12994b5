#include "../test_length.h"
#include "synchronizer_fixture.h"

#include <random>

namespace synchronizer_test {
namespace {

/** \brief Cameras that expose together, 30 times a second, each stamped by a clock of its own. */
struct Clocks {
  std::vector<std::int64_t> started;      // what the clock of each camera shows at host time 0, µs
  std::vector<double> drift;              // it gains this on the host's clock, µs per second
  std::pair<int, int> delay{1000, 6000};  // from exposure to arrival, µs

  std::uint64_t stamp(std::size_t camera, std::int64_t exposed) const {
    return static_cast<std::uint64_t>(started[camera] + exposed +
                                      static_cast<std::int64_t>(drift[camera] * 1e-6 * static_cast<double>(exposed)));
  }

  std::vector<Delivery> deliveries(int frames) const {
    std::mt19937 random(3);
    std::uniform_int_distribution<int> delays(delay.first, delay.second);
    std::vector<Delivery> result;
    for (int frame = 0; frame < frames; ++frame)
      for (std::size_t c = 0; c < started.size(); ++c) {
        const std::int64_t exposed = 1000000 + frame * std::int64_t{33333};
        result.push_back({microseconds(exposed + delays(random)), c, stamp(c, exposed), exposed});
      }
    return result;
  }
};

TEST(ViewSynchronizerClocks, ThatStartedAtDifferentTimesAreBroughtTogether) {
  Clocks clocks{{0, 3600000000, 1700000000000000}, {0, 0, 0}};  // at power-on, an hour ago, the epoch
  Host host(3, {});
  const std::vector<Set> sets = host.play(clocks.deliveries(300));
  EXPECT_EQ(sets.size(), 300u);
  for (const Set& set : sets) {
    EXPECT_EQ(viewCount(set), 3u);
    EXPECT_EQ(trueSpread(set), 0us);
  }
  // On the host's clock, and behind the exposure by the least delay.
  EXPECT_NEAR(static_cast<double>(sets.back().stamp), static_cast<double>(sets.back().views[0]->payload) + 1000, 200);
  EXPECT_NEAR(static_cast<double>(host.synchronizer.getStatistics().cameras[1].offset.count()), -3600000000.0 + 1000,
              200);
}

TEST(ViewSynchronizerClocks, ThatDriftAreFollowedForAnHour) {
  Clocks clocks{{0, 50000000, 7000000}, {200, 0, -200}};  // one gains 0.7 s, one loses as much
  Host host(3, {});
  const int seconds = timesOver(3600, 300);
  const std::vector<Set> sets = host.play(clocks.deliveries(seconds * 30));
  EXPECT_EQ(sets.size(), static_cast<std::size_t>(seconds) * 30);
  for (const Set& set : sets) ASSERT_EQ(trueSpread(set), 0us) << set.stamp;
  const auto statistics = host.synchronizer.getStatistics();
  EXPECT_EQ(statistics.complete_sets, sets.size());
  EXPECT_NEAR(static_cast<double>(statistics.cameras[0].offset.count()), -200.0 * seconds, 3000);
  EXPECT_NEAR(static_cast<double>(statistics.cameras[2].offset.count()), -7000000.0 + 200.0 * seconds, 3000);
  // The offset that grows is behind by up to 10 s of drift, 2 ms; once offsets are known, so far apart are sets believed to be.
  for (std::size_t k = 30; k < sets.size(); ++k) ASSERT_LT(sets[k].spread, 3ms) << sets[k].stamp;
}

TEST(ViewSynchronizerClocks, ThatAreSharedAreComparedAsTheyAreHoweverLongAViewTakes) {
  Host host(2);
  std::vector<Delivery> deliveries;
  for (int frame = 0; frame < 100; ++frame) {
    const microseconds exposed = frame * 33333us;
    const auto stamp = static_cast<std::uint64_t>(exposed.count());
    deliveries.push_back({exposed, 0, stamp, frame});
    deliveries.push_back({exposed + 70ms, 1, stamp, frame});  // two frames behind
  }
  const std::vector<Set> sets = host.play(deliveries);
  EXPECT_EQ(sets.size(), 100u);
  for (const Set& set : sets) EXPECT_EQ(trueSpread(set), 0us);
  EXPECT_EQ(host.synchronizer.getStatistics().cameras[1].offset, 0us);
}

TEST(ViewSynchronizerClocks, OfACameraThatRestartsAreEstimatedAnew) {
  Clocks clocks{{500000000, 500000000}, {0, 0}};
  std::vector<Delivery> deliveries = clocks.deliveries(120);
  for (Delivery& delivery : deliveries)
    if (delivery.camera == 1 && delivery.exposed > 3000000) delivery.stamp -= 503000000;  // it begins at 0
  Host host(2, {});
  const std::vector<Set> sets = host.play(deliveries);
  EXPECT_GE(sets.size(), 119u);
  std::size_t complete = 0;
  for (const Set& set : sets) {
    EXPECT_EQ(trueSpread(set), 0us);
    if (viewCount(set) == 2) ++complete;
  }
  EXPECT_GE(complete, 118u);
  EXPECT_EQ(host.synchronizer.getStatistics().cameras[1].restarts, 1u);
  EXPECT_EQ(host.synchronizer.getStatistics().cameras[0].restarts, 0u);
}

TEST(ViewSynchronizerClocks, ThatAreSharedMayBeginAgainAsARecordingThatIsRepeated) {
  Host host(2);
  std::vector<Delivery> deliveries;
  for (int frame = 0; frame < 90; ++frame)
    for (const std::size_t camera : {0u, 1u})
      deliveries.push_back({frame * 33ms, camera, static_cast<std::uint64_t>(frame % 30) * 33000, frame});
  const std::vector<Set> sets = host.play(deliveries);
  EXPECT_EQ(sets.size(), 90u);
  for (const Set& set : sets) EXPECT_EQ(trueSpread(set), 0us);
}

TEST(ViewSynchronizerClocks, ThatAreSetForwardAreFollowedAtOnce) {
  Clocks clocks{{0, 0}, {0, 0}};
  std::vector<Delivery> deliveries = clocks.deliveries(90);
  for (Delivery& delivery : deliveries)
    if (delivery.camera == 0 && delivery.exposed > 2000000) delivery.stamp += 5000000;
  Host host(2, {});
  const std::vector<Set> sets = host.play(deliveries);
  EXPECT_GE(sets.size(), 88u);
  for (const Set& set : sets) EXPECT_EQ(trueSpread(set), 0us);
}

}  // namespace
}  // namespace synchronizer_test
