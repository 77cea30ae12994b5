#include "synchronizer_fixture.h"

#include <atomic>

// Bursts, numbers at the end of their range, and clocks that jump back.

namespace synchronizer_test {
namespace {

using fuse_flow::ClockModel;
using fuse_flow::SynchronizerParameters;

constexpr std::uint64_t kHalfOfAll = std::uint64_t{1} << 63;

/** \brief Complete sets of two cameras at 25 Hz whose first stamp is given. */
std::vector<Set> setsFrom(std::uint64_t first, ClockModel clocks, std::uint64_t second_is_ahead = 0) {
  SynchronizerParameters parameters;
  parameters.clocks = clocks;
  Host host(2, parameters);
  std::vector<Delivery> deliveries;
  for (int frame = 0; frame < 50; ++frame)
    for (const std::size_t camera : {0u, 1u})
      deliveries.push_back({frame * 40ms, camera,
                            first + static_cast<std::uint64_t>(frame) * 40000 + (camera == 1 ? second_is_ahead : 0),
                            frame});
  return host.play(deliveries);
}

TEST(ViewSynchronizerExtremes, ABurstDrivesOutNoViews) {
  SynchronizerParameters parameters = sharedClock();
  parameters.max_wait = 10s;
  Host host(2, parameters);
  for (const microseconds time : {0us, 1us, 9000000us}) host.push(0, time);
  const auto counts = host.synchronizer.getStatistics().cameras[0];
  EXPECT_EQ(counts.overrun, 0u) << "of nine million frames of 1 us none was lost";
  EXPECT_EQ(counts.waiting, 3u);
}

TEST(ViewSynchronizerExtremes, ABurstThenASteadyRateGivesCompleteSets) {
  SynchronizerParameters parameters = sharedClock();
  parameters.max_wait = 10s;
  Host host(2, parameters);
  std::vector<Delivery> deliveries{{0us, 0, 0, 0}, {0us, 1, 0, 0}, {1us, 0, 1, 1}};
  addStream(deliveries, 0, 40ms, 2s, 40ms);
  addStream(deliveries, 1, 40ms, 2s, 40ms);
  const std::vector<Set> sets = host.play(deliveries);
  EXPECT_EQ(sets.size(), 50u);
  for (const Set& set : sets) EXPECT_EQ(viewCount(set), 2u) << set.stamp;
}

TEST(ViewSynchronizerExtremes, PlacesOfLostFramesTakeNoViewsPlace) {
  SynchronizerParameters parameters = sharedClock();
  parameters.capacity = 4;
  Host host(2, parameters);
  for (const microseconds time : {0us, 10000us, 20000us, 60000us}) host.push(0, time);
  EXPECT_EQ(host.synchronizer.getStatistics().cameras[0].overrun, 0u);
  EXPECT_EQ(host.synchronizer.getStatistics().cameras[0].waiting, 4u);
}

TEST(ViewSynchronizerExtremes, StampsUpToTheLargestAreAsGoodAsOthers) {
  for (const ClockModel clocks : {ClockModel::Shared, ClockModel::Separate})
    for (const std::uint64_t first : {kHalfOfAll - 1000000, kHalfOfAll - 1, kHalfOfAll, 0 - std::uint64_t{1000000}}) {
      const std::vector<Set> sets = setsFrom(first, clocks);
      EXPECT_EQ(sets.size(), 50u) << first;
      for (const Set& set : sets) {
        EXPECT_EQ(viewCount(set), 2u) << first;
        EXPECT_EQ(trueSpread(set), 0us) << first;
        EXPECT_EQ(set.spread, 0us) << first;
      }
      for (std::size_t k = 1; k < sets.size(); ++k) EXPECT_EQ(sets[k].stamp - sets[k - 1].stamp, 40000u) << first;
    }
}

TEST(ViewSynchronizerExtremes, ClocksOfTheirOwnMayBeAnyTimeApart) {
  for (const std::uint64_t ahead : {kHalfOfAll, kHalfOfAll - 1, kHalfOfAll + 1, ~std::uint64_t{0}})
    for (const Set& set : setsFrom(5, ClockModel::Separate, ahead)) {
      EXPECT_EQ(viewCount(set), 2u) << ahead;
      EXPECT_EQ(trueSpread(set), 0us) << ahead;
    }
}

TEST(ViewSynchronizerExtremes, ViewsAsFarApartAsNumbersGoAreNoSet) {
  for (const std::uint64_t ahead : {kHalfOfAll, kHalfOfAll - 1, kHalfOfAll + 1})
    for (const Set& set : setsFrom(5, ClockModel::Shared, ahead)) EXPECT_EQ(viewCount(set), 1u) << ahead;
}

TEST(ViewSynchronizerExtremes, DurationsWithoutEndCountAsAYear) {
  SynchronizerParameters parameters;
  parameters.tolerance = parameters.max_wait = parameters.offset_window = microseconds::max();
  for (const ClockModel clocks : {ClockModel::Shared, ClockModel::Separate}) {
    parameters.clocks = clocks;
    Host host(2, parameters);
    for (int frame = 0; frame < 20; ++frame) {
      host.now = frame * 40ms;
      host.push(0, host.now);
      EXPECT_FALSE(host.synchronizer.take()) << frame;
      host.push(1, host.now);
      const auto set = host.synchronizer.take();
      ASSERT_TRUE(set) << frame;
      EXPECT_EQ(viewCount(*set), 2u) << frame;
    }
    host.now = 2s;
    host.push(0, host.now);
    host.now = std::chrono::hours(24 * 300);
    EXPECT_FALSE(host.synchronizer.take()) << "less than a year";
    host.now = std::chrono::hours(24 * 400);
    EXPECT_TRUE(host.synchronizer.take());
  }
}

TEST(ViewSynchronizerExtremes, WaitSleepsHoweverLongAViewMayWait) {
  for (const microseconds max_wait : {microseconds::max(), microseconds::max() - 1us, microseconds(10s)}) {
    SynchronizerParameters parameters = sharedClock();
    parameters.max_wait = max_wait;
    std::atomic<int> looks{0};
    fuse_flow::ViewSynchronizer<int> synchronizer(2, parameters, [&] {
      ++looks;
      return 5s;
    });
    synchronizer.push(0, 1, 1);
    EXPECT_FALSE(synchronizer.wait(50ms));
    EXPECT_LT(looks, 30) << "it looks at the clock whenever it wakes up";
    EXPECT_FALSE(synchronizer.wait(microseconds::min()));
  }
}

/** \brief A recording of a second that is played three times, as a clock that is set back does. */
TEST(ViewSynchronizerExtremes, StampsOfSetsGrowWhenASharedClockJumpsBack) {
  Host host(2);
  std::vector<Delivery> deliveries;
  for (int frame = 0; frame < 75; ++frame)
    for (const std::size_t camera : {0u, 1u})
      deliveries.push_back({frame * 40ms, camera, 1000000 + static_cast<std::uint64_t>(frame % 25) * 40000, frame});
  const std::vector<Set> sets = host.play(deliveries);
  ASSERT_EQ(sets.size(), 75u);
  for (std::size_t k = 0; k < sets.size(); ++k) {
    EXPECT_EQ(sets[k].stamp, 1000000 + k * 40000) << "as time has passed";
    EXPECT_EQ(sets[k].views[0]->stamp, 1000000 + k % 25 * 40000) << "as it was pushed";
  }
}

TEST(ViewSynchronizerExtremes, StampsOfSetsAreTheSharedClocksAgainOnceItIsAheadOfThem) {
  Host host(1);
  std::vector<std::uint64_t> stamps;
  for (const std::uint64_t stamp : {5000000, 5040000, 1000000, 1040000, 6000000, 6040000}) {
    host.synchronizer.push(0, stamp, 0);
    stamps.push_back(host.synchronizer.take()->stamp);
    host.now += 40ms;
  }
  EXPECT_EQ(stamps, (std::vector<std::uint64_t>{5000000, 5040000, 5080000, 5120000, 6000000, 6040000}));
}

TEST(ViewSynchronizerExtremes, AViewFromBeforeASharedClockJumpedBackHoldsUpNoOne) {
  Host host(3);
  std::vector<Delivery> deliveries;
  for (const std::size_t camera : {0u, 1u, 2u}) addStream(deliveries, camera, 0us, 1s, 40ms);
  deliveries.push_back({1s, 2, 1000000, 0});  // its last; the others never have it
  for (int frame = 0; frame < 50; ++frame)
    for (const std::size_t camera : {0u, 1u})
      deliveries.push_back({1s + (frame + 1) * 40ms, camera, static_cast<std::uint64_t>(frame) * 40000, frame});
  const std::vector<Set> sets = host.play(deliveries);
  std::size_t of_both = 0;
  for (std::size_t k = 0; k < sets.size(); ++k) {
    if (sets[k].views[0] && sets[k].views[1] && !sets[k].views[2]) ++of_both;
    if (k > 0) {
      EXPECT_GT(sets[k].stamp, sets[k - 1].stamp);
    }
  }
  EXPECT_GE(of_both, 47u) << "but for the first tenth of a second, in which the third is waited for";
}

}  // namespace
}  // namespace synchronizer_test
