#include "synchronizer_fixture.h"

#include <atomic>
#include <future>
#include <memory>
#include <thread>

namespace synchronizer_test {
namespace {

using fuse_flow::ViewSynchronizer;

TEST(ViewSynchronizerThreads, PushFromEveryCameraWhileOneTakes) {
  constexpr std::size_t cameras = 6;
  constexpr std::uint64_t frames = 400;
  fuse_flow::SynchronizerParameters parameters = sharedClock();
  parameters.max_wait = 10min;  // however slow the machine: no camera is given up
  parameters.capacity = frames;
  ViewSynchronizer<std::unique_ptr<std::uint64_t>> synchronizer(cameras, parameters);
  std::vector<std::thread> grabbers;
  for (std::size_t camera = 0; camera < cameras; ++camera)
    grabbers.emplace_back([&synchronizer, camera] {
      for (std::uint64_t frame = 1; frame <= frames; ++frame)
        synchronizer.push(camera, frame * 33333 + camera, std::make_unique<std::uint64_t>(frame));
    });
  std::uint64_t last = 0, sets = 0;
  while (last < frames) {
    const auto set = synchronizer.wait(5min);
    const auto in_set = [](const auto& view) { return view.has_value(); };
    EXPECT_TRUE(set && std::all_of(set->views.begin(), set->views.end(), in_set));
    if (testing::Test::HasFailure()) break;
    ++sets;
    for (const auto& view : set->views) EXPECT_EQ(*view->payload, *set->views[0]->payload);
    EXPECT_GT(*set->views[0]->payload, last);
    last = *set->views[0]->payload;
  }
  for (std::thread& grabber : grabbers) grabber.join();
  for (const auto& c : synchronizer.getStatistics().cameras) {
    EXPECT_EQ(c.received, frames);
    EXPECT_EQ(c.used, sets);
    EXPECT_EQ(c.unmatched, frames - sets);
  }
}

TEST(ViewSynchronizerThreads, WaitForAsLongAsThereAreNumbers) {
  ViewSynchronizer<int> synchronizer(1, sharedClock());
  std::promise<void> waits;
  auto set = std::async(std::launch::async, [&] {
    waits.set_value();
    return synchronizer.wait(std::chrono::microseconds::max());
  });
  waits.get_future().wait();
  std::this_thread::sleep_for(20ms);  // in which a wait that ends at once has ended
  synchronizer.push(0, 1, 5);
  EXPECT_TRUE(set.get().has_value());
}

TEST(ViewSynchronizerThreads, PushWhileAConsumerIsBusyFreeingViews) {
  std::promise<void> freeing, go_on;
  std::shared_future<void> may_go_on(go_on.get_future());
  ViewSynchronizer<std::shared_ptr<int>> synchronizer(1, sharedClock());
  synchronizer.push(0, 1, std::shared_ptr<int>(new int(0), [&](int* value) {
                      freeing.set_value();
                      may_go_on.wait();
                      delete value;
                    }));
  synchronizer.push(0, 33333, std::make_shared<int>(1));
  std::thread consumer([&] { synchronizer.take(); });  // takes the second, and frees the first
  freeing.get_future().wait();
  synchronizer.push(0, 66666, std::make_shared<int>(2));  // would hang here
  const auto set = synchronizer.take();
  go_on.set_value();
  consumer.join();
  ASSERT_TRUE(set);
  EXPECT_EQ(*set->views[0]->payload, 2);
}

TEST(ViewSynchronizerThreads, PushToAFullQueueWhileAnotherCameraIsBusyFreeingItsOldest) {
  std::promise<void> freeing, go_on;
  std::shared_future<void> may_go_on(go_on.get_future());
  fuse_flow::SynchronizerParameters parameters = sharedClock();
  parameters.capacity = 1;
  ViewSynchronizer<std::shared_ptr<int>> synchronizer(2, parameters);
  synchronizer.push(0, 1, std::shared_ptr<int>(new int(0), [&](int* value) {
                      freeing.set_value();
                      may_go_on.wait();
                      delete value;
                    }));
  std::thread grabber([&] { synchronizer.push(0, 33333, std::make_shared<int>(1)); });
  freeing.get_future().wait();
  synchronizer.push(1, 33333, std::make_shared<int>(1));
  const bool complete = synchronizer.take().has_value();
  go_on.set_value();
  grabber.join();
  EXPECT_TRUE(complete);
}

/** \brief A view whose delay turns out to have been longer than was thought may belong before the last set; then there is something to
 *  free, and nothing to hand out. */
TEST(ViewSynchronizerThreads, PushWhileAWaitingConsumerFreesAViewThatCameTooLate) {
  std::promise<void> freeing, go_on;
  std::shared_future<void> may_go_on(go_on.get_future());
  std::atomic<std::int64_t> now{1050000};
  ViewSynchronizer<std::shared_ptr<int>> synchronizer(2, {}, [&] { return microseconds(now); });
  synchronizer.push(0, 1050000, std::make_shared<int>(0));
  synchronizer.push(1, 1000000, std::make_shared<int>(0));  // as if its clock were 50 ms behind
  ASSERT_TRUE(synchronizer.take());
  now = 1070500;
  synchronizer.push(1, 1020000, std::shared_ptr<int>(new int(1), [&](int* value) {
                      freeing.set_value();
                      may_go_on.wait();
                      delete value;
                    }));
  now = 1075000;
  synchronizer.push(1, 1060000, std::make_shared<int>(2));  // it is 15 ms behind at most
  std::future<int> taken = std::async(std::launch::async, [&] {
    const auto set = synchronizer.wait(5min);
    return set && set->views[0] && set->views[1] ? *set->views[1]->payload : -1;
  });
  freeing.get_future().wait();
  synchronizer.push(0, 1075000, std::make_shared<int>(2));  // would hang here
  go_on.set_value();
  EXPECT_EQ(taken.get(), 2);
}

TEST(ViewSynchronizerThreads, WakeAWaitingConsumerWithTheLastViewOfASet) {
  ViewSynchronizer<int> synchronizer(2, sharedClock());
  synchronizer.push(0, 33333, 1);
  std::future<bool> taken = std::async(std::launch::async, [&] { return synchronizer.wait(5min).has_value(); });
  synchronizer.push(1, 33333, 1);
  EXPECT_TRUE(taken.get());
}

TEST(ViewSynchronizerThreads, GiveASleepingConsumerWhatHasWaitedLongEnough) {
  fuse_flow::SynchronizerParameters parameters = sharedClock();
  parameters.max_wait = 5ms;
  ViewSynchronizer<int> synchronizer(2, parameters);
  synchronizer.push(0, 33333, 1);
  const auto set = synchronizer.wait(5min);  // nobody else pushes
  ASSERT_TRUE(set);
  EXPECT_FALSE(set->views[1]);
}

TEST(ViewSynchronizerThreads, LeaveAConsumerWithoutASetAfterItsTimeout) {
  ViewSynchronizer<int> synchronizer(1);
  EXPECT_FALSE(synchronizer.wait(1ms));
}

}  // namespace
}  // namespace synchronizer_test
