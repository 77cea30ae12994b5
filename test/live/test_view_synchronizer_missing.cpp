#include "synchronizer_fixture.h"

namespace synchronizer_test {
namespace {

TEST(ViewSynchronizerMissingViews, OfCamerasWithDifferentRatesTheSlowestSetsThePace) {
  Host host(3);
  std::vector<Delivery> deliveries;
  addStream(deliveries, 0, 0us, 2s, 16667us);  // 60, 30 and 15 Hz
  addStream(deliveries, 1, 0us, 2s, 33333us);
  addStream(deliveries, 2, 0us, 2s, 66667us);
  const std::vector<Set> sets = host.play(deliveries);
  ASSERT_GE(sets.size(), 30u);
  for (std::size_t k = 0; k < 30; ++k) {
    ASSERT_EQ(viewCount(sets[k]), 3u);
    EXPECT_EQ(sets[k].views[2]->payload, 66667 * static_cast<int>(k));
    EXPECT_LT(trueSpread(sets[k]), 1ms);
  }
  for (std::size_t k = 30; k < sets.size(); ++k) EXPECT_FALSE(sets[k].views[2]) << "the others go on for 0.07 s";
  const auto statistics = host.synchronizer.getStatistics();
  EXPECT_EQ(statistics.cameras[2].unmatched, 0u);
  EXPECT_GE(statistics.cameras[0].unmatched, 29u * 3);
}

TEST(ViewSynchronizerMissingViews, AFrameThatOneCameraLosesLeavesTheOthersTheirSet) {
  std::vector<Delivery> deliveries;
  for (std::size_t c = 0; c < 3; ++c) addStream(deliveries, c, 0us, 2s, 40ms);
  // Camera 0, which is the first to deliver each time, lacks the views of 0.80, 1.20 and 1.24 s.
  const auto lost = [](const Delivery& delivery) {
    return delivery.camera == 0 &&
           (delivery.exposed == 800000 || delivery.exposed == 1200000 || delivery.exposed == 1240000);
  };
  deliveries.erase(std::remove_if(deliveries.begin(), deliveries.end(), lost), deliveries.end());
  fuse_flow::SynchronizerParameters patient = sharedClock();
  patient.max_wait = 200ms;
  Host host(3, patient);
  const std::vector<Set> sets = host.play(deliveries);
  std::vector<std::uint64_t> without;
  for (const Set& set : sets) {
    EXPECT_TRUE(set.views[1] && set.views[2]);
    EXPECT_EQ(trueSpread(set), 0us);
    if (!set.views[0]) without.push_back(set.stamp);
  }
  // Both losses of 1.20 s show with the view of 1.28 s; then the later of the two sets goes first.
  EXPECT_EQ(without, (std::vector<std::uint64_t>{800000, 1240000}));
  EXPECT_EQ(sets.size(), 49u);
}

TEST(ViewSynchronizerMissingViews, AnInstantThatEveryCameraLostIsNoSet) {
  fuse_flow::SynchronizerParameters narrow = sharedClock();
  narrow.tolerance = 1ms;
  Host host(2, narrow);
  for (const int time : {100, 140, 220}) host.push(0, time * 1ms);  // lacks 180
  for (const int time : {121, 151, 211})
    host.push(1, time * 1ms);  // lacks 181: the only instant that both could have had
  host.now = 1s;
  const auto set = host.synchronizer.take();
  ASSERT_TRUE(set);
  EXPECT_EQ(viewCount(*set), 1u);
  EXPECT_EQ(set->stamp, 220000u);
}

TEST(ViewSynchronizerMissingViews, ACameraThatBecomesSlowerSetsThePaceAgain) {
  Host host(2);
  std::vector<Delivery> deliveries;
  addStream(deliveries, 0, 0us, 1s, 40ms);  // the first to deliver each time
  addStream(deliveries, 0, 1s, 3s, 80ms);
  addStream(deliveries, 1, 0us, 3s, 40ms);
  for (const Set& set : host.play(deliveries)) {
    if (set.stamp > 1500000 && set.stamp < 2950000) {
      EXPECT_EQ(viewCount(set), 2u) << set.stamp;
    }
  }
  EXPECT_GE(host.synchronizer.getStatistics().complete_sets, 25u + 25u);
}

TEST(ViewSynchronizerMissingViews, AClockThatLeapsForwardLosesNoFrames) {
  Host host(1);
  for (const microseconds time : {100ms, 140ms, 180ms}) host.push(0, time);
  host.push(0, microseconds(300000000000000));  // ten years: nothing is put in their place
  EXPECT_EQ(host.synchronizer.getStatistics().cameras[0].waiting, 4u);
  EXPECT_EQ(host.synchronizer.take()->stamp, 300000000000000u);
}

TEST(ViewSynchronizerMissingViews, AStalledCameraIsMissingAndComesBack) {
  Host host(3);
  std::vector<Delivery> deliveries;
  addStream(deliveries, 0, 0us, 4s, 40ms);
  addStream(deliveries, 1, 0us, 4s, 40ms);
  addStream(deliveries, 2, 0us, 1s, 40ms);
  addStream(deliveries, 2, 3s, 4s, 40ms);
  const std::vector<Set> sets = host.play(deliveries);
  std::vector<std::uint64_t> without;
  for (const Set& set : sets) {
    ASSERT_TRUE(set.views[0] && set.views[1]);
    if (!set.views[2]) without.push_back(set.stamp);
  }
  // The first view to wait is that of 1.00 s; at 1.10 s the camera is given up, and from then on nothing waits for it.
  ASSERT_FALSE(without.empty());
  EXPECT_EQ(without.front(), 1080000u);
  // The view of 3.00 s comes after those of the others and is late; the camera is back with the next.
  EXPECT_EQ(without.back(), 3000000u);
  EXPECT_EQ(without.size(), (3000u - 1080u) / 40 + 1);
  EXPECT_EQ(sets.size(), 25u + without.size() + 24u);
  const auto statistics = host.synchronizer.getStatistics();
  EXPECT_EQ(statistics.cameras[2].late, 1u);
  EXPECT_EQ(statistics.cameras[0].unmatched, 2u) << "1.00 and 1.04 s, which waited";
  EXPECT_EQ(statistics.incomplete_sets, without.size());
}

TEST(ViewSynchronizerMissingViews, AStalledCameraDelaysOneSetByMaxWaitAndTheOnesAfterItNotAtAll) {
  Host host(2);
  host.push(0, 0us);
  host.now = 100ms - 1us;
  EXPECT_FALSE(host.synchronizer.take());
  EXPECT_TRUE(host.synchronizer.getStatistics().cameras[1].waited_for);
  host.now = 100ms;
  EXPECT_TRUE(host.synchronizer.take());
  EXPECT_FALSE(host.synchronizer.getStatistics().cameras[1].waited_for);
  host.push(0, 133ms);
  EXPECT_TRUE(host.synchronizer.take());
  host.push(1, 166ms);
  EXPECT_FALSE(host.synchronizer.take()) << "it is back, and the other is waited for";
  EXPECT_TRUE(host.synchronizer.getStatistics().cameras[1].waited_for);
}

TEST(ViewSynchronizerMissingViews, ACameraThatNeverDeliversIsMissingFromEverySet) {
  Host host(2);
  std::vector<Delivery> deliveries;
  addStream(deliveries, 1, 0us, 2s, 50ms);
  const std::vector<Set> sets = host.play(deliveries);
  EXPECT_EQ(sets.size(), 40u - 2) << "of the views of the first 0.1 s, the latest";
  for (const Set& set : sets) EXPECT_TRUE(!set.views[0] && set.views[1]);
}

TEST(ViewSynchronizerMissingViews, AFrozenCameraThatRepeatsItsLastViewIsNotWaitedFor) {
  Host host(2);
  host.push(0, 0us);
  host.push(1, 0us);
  ASSERT_TRUE(host.synchronizer.take());
  std::size_t at_once = 0;
  for (int frame = 1; frame <= 20; ++frame) {
    host.now = frame * 33ms;
    host.push(1, 0us);
    host.push(0, host.now);
    if (host.synchronizer.take()) ++at_once;
  }
  EXPECT_EQ(at_once, 16u) << "not the views of 33 to 132 ms: the first of them has waited long enough at 133";
  EXPECT_EQ(host.synchronizer.getStatistics().cameras[1].repeated, 20u);
}

}  // namespace
}  // namespace synchronizer_test
