#include "synchronizer_fixture.h"

#include <pcl/exceptions.h>

#include <memory>
#include <numeric>
#include <random>
#include <string>
#include <utility>

namespace synchronizer_test {
namespace {

using fuse_flow::ViewSynchronizer;

TEST(ViewSynchronizer, ViewsWithOneStampBecomeASetAsSoonAsTheLastOfThemArrives) {
  Host host(3);
  host.push(2, 5000us);
  host.push(0, 5000us);
  EXPECT_FALSE(host.synchronizer.take());
  host.push(1, 5000us);
  const auto set = host.synchronizer.take();
  ASSERT_TRUE(set);
  EXPECT_EQ(set->stamp, 5000u);
  EXPECT_EQ(set->spread, 0us);
  EXPECT_EQ(viewCount(*set), 3u);
  EXPECT_EQ(set->views[1]->stamp, 5000u);
  EXPECT_EQ(set->views[1]->payload, 5000);
  EXPECT_FALSE(host.synchronizer.take()) << "a view goes out once";
}

TEST(ViewSynchronizer, ASetIsStampedInTheMiddleOfViewsThatDifferByUpToTwiceTheTolerance) {
  Host host(2);  // 8 ms
  host.push(0, 100ms);
  host.push(1, 116ms);
  const auto set = host.synchronizer.take();
  ASSERT_TRUE(set);
  EXPECT_EQ(set->stamp, 108000u);
  EXPECT_EQ(set->spread, 16ms);
  host.push(0, 200ms);
  host.push(1, 216ms + 1us);
  EXPECT_FALSE(host.synchronizer.take());
}

TEST(ViewSynchronizer, TheOrderInWhichCamerasDeliverDoesNotMatter) {
  std::vector<std::size_t> order(4);
  std::iota(order.begin(), order.end(), std::size_t{0});
  do {
    Host host(4);
    for (const int instant : {0, 33})
      for (const std::size_t camera : order) host.push(camera, (instant + static_cast<int>(camera)) * 1ms);
    const auto set = host.synchronizer.take();
    ASSERT_TRUE(set);
    EXPECT_EQ(set->stamp, 34500u);
    for (std::size_t c = 0; c < 4; ++c) EXPECT_EQ(set->views[c]->payload, 33000 + 1000 * static_cast<int>(c));
    EXPECT_FALSE(host.synchronizer.take());
  } while (std::next_permutation(order.begin(), order.end()));
}

TEST(ViewSynchronizer, JitterWithinTheToleranceLosesNoSet) {
  Host host(4);
  std::mt19937 random(1);
  std::uniform_int_distribution<int> stamp_jitter(-3000, 3000), delay(0, 40000);
  std::vector<Delivery> deliveries;
  std::vector<microseconds> last_arrival(4, 0us);
  for (int frame = 1; frame <= 300; ++frame)
    for (std::size_t c = 0; c < 4; ++c) {
      const microseconds exposed = frame * 33333us + microseconds(stamp_jitter(random));
      last_arrival[c] = std::max(last_arrival[c] + 1us, exposed + microseconds(delay(random)));
      deliveries.push_back({last_arrival[c], c, static_cast<std::uint64_t>(exposed.count()), frame});
    }
  const std::vector<Set> sets = host.play(deliveries);
  ASSERT_EQ(sets.size(), 300u);
  for (std::size_t k = 0; k < sets.size(); ++k)
    for (const auto& view : sets[k].views) {
      ASSERT_TRUE(view);
      EXPECT_EQ(view->payload, static_cast<int>(k) + 1);
    }
  const auto statistics = host.synchronizer.getStatistics();
  EXPECT_EQ(statistics.complete_sets, 300u);
  EXPECT_LE(statistics.largest_spread, 6ms);
  EXPECT_GT(statistics.mean_spread, 1ms);
  EXPECT_LT(statistics.mean_spread, statistics.largest_spread);
}

TEST(ViewSynchronizer, AViewThatBelongsToThePreviousOnesOfTheOthersIsPutWithThem) {
  fuse_flow::SynchronizerParameters wide = sharedClock();
  wide.tolerance = 15ms;  // so that 10 ms could also go with 33 ms
  Host host(3, wide);
  host.push(0, 1000ms);
  host.push(2, 1001ms);
  host.push(0, 1033ms);
  host.push(2, 1034ms);
  host.push(1, 1010ms);
  const auto set = host.synchronizer.take();
  ASSERT_TRUE(set);
  EXPECT_EQ(set->views[0]->payload, 1000000);
  EXPECT_EQ(set->views[1]->payload, 1010000);
  EXPECT_EQ(set->views[2]->payload, 1001000);
}

TEST(ViewSynchronizer, CamerasThatExposeTooFarApartStillGiveASetWithinMaxWait) {
  Host host(2);
  std::vector<Delivery> deliveries;
  addStream(deliveries, 0, 0us, 2s, 50ms);
  addStream(deliveries, 1, 25ms, 2s, 50ms);
  const std::vector<Set> sets = host.play(deliveries);
  EXPECT_GE(sets.size(), 16u) << "one every 0.125 s: what is left after a set has come 0.025 s after it";
  EXPECT_EQ(host.synchronizer.getStatistics().complete_sets, 0u);
}

TEST(ViewSynchronizer, AViewThatWasOnItsWayHasWaitedSinceItArrived) {
  Host host(2);  // waits for 100 ms
  host.now = 1000ms;
  host.synchronizer.push(0, 5000, 5000, 901ms);
  EXPECT_FALSE(host.synchronizer.take());
  host.now += 1ms;
  ASSERT_TRUE(host.synchronizer.take()) << "100 ms after it arrived";
  EXPECT_THROW(host.synchronizer.push(2, 0, 0, 0ms), pcl::BadArgumentException);
  Host other(2);
  other.now = 1000ms;
  other.synchronizer.push(0, 5000, 5000, 5000ms);  // no view arrives later than now
  other.now += 99ms;
  EXPECT_FALSE(other.synchronizer.take());
  other.now += 1ms;
  EXPECT_TRUE(other.synchronizer.take());
}

TEST(ViewSynchronizer, AViewThatComesAfterItsSetIsDroppedAndStampsGrow) {
  Host host(2);
  host.push(0, 500ms);
  host.now = 100ms;
  ASSERT_TRUE(host.synchronizer.take());
  host.push(1, 500ms);
  host.now = 300ms;
  EXPECT_FALSE(host.synchronizer.take());
  EXPECT_EQ(host.synchronizer.getStatistics().cameras[1].late, 1u);
}

TEST(ViewSynchronizer, OneCameraAloneGivesASetAView) {
  Host host(1);
  for (int frame = 0; frame < 5; ++frame) {
    host.push(0, frame * 10ms);
    const auto set = host.synchronizer.take();
    ASSERT_TRUE(set);
    EXPECT_EQ(set->stamp, static_cast<std::uint64_t>(frame) * 10000);
  }
}

TEST(ViewSynchronizer, SixtyFourCamerasGiveCompleteSets) {
  Host host(64);
  std::vector<Delivery> deliveries;
  for (std::size_t c = 0; c < 64; ++c) addStream(deliveries, c, static_cast<int>(c) * 100us, 990ms, 33333us);
  const std::vector<Set> sets = host.play(deliveries);
  EXPECT_EQ(sets.size(), 30u);
  for (const Set& set : sets) EXPECT_EQ(set.spread, 6300us);
  EXPECT_EQ(host.synchronizer.getStatistics().complete_sets, 30u);
}

TEST(ViewSynchronizer, ASlowConsumerGetsTheLatestSet) {
  Host host(2);
  for (int frame = 0; frame < 6; ++frame)
    for (const std::size_t camera : {0u, 1u}) host.push(camera, frame * 33ms);
  const auto set = host.synchronizer.take();
  ASSERT_TRUE(set);
  EXPECT_EQ(set->stamp, 165000u);
  EXPECT_FALSE(host.synchronizer.take());
  EXPECT_EQ(host.synchronizer.getStatistics().cameras[0].unmatched, 5u);
}

TEST(ViewSynchronizer, WithoutAConsumerOnlyTheNewestViewsAreKept) {
  ViewSynchronizer<std::shared_ptr<int>> synchronizer(2, sharedClock(), [] { return 0us; });
  std::vector<std::weak_ptr<int>> views;
  for (int frame = 0; frame < 1000; ++frame)
    for (const std::size_t camera : {0u, 1u}) {
      auto view = std::make_shared<int>(frame);
      views.push_back(view);
      synchronizer.push(camera, static_cast<std::uint64_t>(frame) * 33333, std::move(view));
    }
  EXPECT_EQ(std::count_if(views.begin(), views.end(), [](const auto& view) { return !view.expired(); }), 2 * 8);
  EXPECT_FALSE(views.back().expired());
  EXPECT_EQ(synchronizer.getStatistics().cameras[1].overrun, 992u);
  EXPECT_EQ(*synchronizer.take()->views[0]->payload, 999);
  EXPECT_EQ(std::count_if(views.begin(), views.end(), [](const auto& view) { return !view.expired(); }), 0);
}

TEST(ViewSynchronizer, ARepeatedOrReorderedViewIsDropped) {
  Host host(1);
  host.push(0, 1000ms);
  host.push(0, 1000ms);
  host.push(0, 950ms);
  EXPECT_EQ(host.synchronizer.take()->stamp, 1000000u);
  EXPECT_FALSE(host.synchronizer.take());
  const auto counts = host.synchronizer.getStatistics().cameras[0];
  EXPECT_EQ(counts.repeated, 1u);
  EXPECT_EQ(counts.late, 1u);
  EXPECT_EQ(counts.restarts, 0u);
}

TEST(ViewSynchronizer, EveryViewIsAccountedFor) {
  Host host(3);
  std::mt19937 random(7);
  std::uniform_int_distribution<int> camera(0, 2), step(-30, 40);
  int time = 0;
  for (int k = 0; k < 5000; ++k) {
    time = std::max(0, time + (k % 500 == 499 ? -2000 : step(random)));  // ms, now and then back to where it was
    host.now += 7ms;
    host.push(static_cast<std::size_t>(camera(random)), time * 1ms);
    if (k % 3 == 0) host.synchronizer.take();
  }
  for (const auto& c : host.synchronizer.getStatistics().cameras) {
    EXPECT_EQ(c.received, c.used + c.overrun + c.unmatched + c.late + c.repeated + c.waiting);
    EXPECT_GT(c.restarts, 0u);
    EXPECT_GT(c.used, 0u);
  }
}

/** \brief What a value that is out of range is answered with. */
std::string refusal(const fuse_flow::SynchronizerParameters& parameters, std::size_t cameras = 2) {
  try {
    ViewSynchronizer<int> synchronizer(cameras, parameters);
  } catch (const pcl::BadArgumentException& error) {
    return error.what();
  }
  return "accepted";
}

TEST(ViewSynchronizer, ValuesOutOfRangeAreRefusedByName) {
  using Parameters = fuse_flow::SynchronizerParameters;
  const std::vector<std::pair<std::string, microseconds Parameters::*>> durations{
      {"tolerance", &Parameters::tolerance},
      {"max_wait", &Parameters::max_wait},
      {"offset_window", &Parameters::offset_window}};
  for (const auto& [name, member] : durations)
    for (const microseconds value : {0us, -5us}) {
      Parameters parameters;
      parameters.*member = value;
      const std::string expected = name + " is " + std::to_string(value.count());
      EXPECT_NE(refusal(parameters).find(expected), std::string::npos) << refusal(parameters);
    }
  Parameters none;
  none.capacity = 0;
  EXPECT_NE(refusal(none).find("capacity is 0"), std::string::npos);
  EXPECT_NE(refusal({}, 0).find("cameras is 0"), std::string::npos);
  EXPECT_EQ(refusal({}), "accepted");
  Host host(2);
  EXPECT_THROW(host.push(2, 0us), pcl::BadArgumentException);
}

}  // namespace
}  // namespace synchronizer_test
