#include "live/prepared_instants.h"

#include "hand_fed_cameras.h"

#include <fuse_flow/recordings/error.h>

#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <stdexcept>

namespace {

using namespace live_test;
using namespace std::chrono_literals;

constexpr auto kLong = 60000ms;  // a test that waits so long has failed

/** \brief One camera that is fed by hand, its instants prepared by a function of a test. */
class PreparedInstants : public ::testing::Test {
 protected:
  PreparedInstants() {
    auto owned = std::make_unique<HandFedCameras>(std::vector<std::string>{"one"});
    source_ = owned.get();
    std::vector<std::unique_ptr<io::CameraSource>> sources;
    sources.push_back(std::move(owned));
    io::LiveRig::Options options;
    options.clock = [] { return 100s; };
    rig_ = std::make_unique<io::LiveRig>(std::move(sources), options);
    rig_->start();
  }

  HandFedCameras* source_{nullptr};
  std::unique_ptr<io::LiveRig> rig_;
};

TEST_F(PreparedInstants, ComeInTheirOrderAndPrepared) {
  io::PreparedInstants prepared(*rig_, [](io::LiveInstant& instant) { instant.rig.stamp += 1; });
  EXPECT_EQ(prepared.next(0ms), nullptr);
  for (std::uint64_t k = 1; k <= 5; ++k) {
    source_->deliver(0, k * 1000000);
    const std::shared_ptr<io::LiveInstant> instant = prepared.next(kLong);
    ASSERT_TRUE(instant);
    EXPECT_EQ(instant->rig.stamp, k * 1000000 + 1);
    EXPECT_FALSE(instant->rig.views[0].missing());
  }
}

TEST_F(PreparedInstants, ArePreparedWhileTheOneBeforeIsInUse) {
  std::atomic<int> begun{0};
  std::promise<void> second;
  io::PreparedInstants prepared(*rig_, [&](io::LiveInstant&) {
    if (++begun == 2) second.set_value();
  });
  source_->deliver(0, 1000000);
  const std::shared_ptr<io::LiveInstant> first = prepared.next(kLong);
  ASSERT_TRUE(first);
  source_->deliver(0, 2000000);
  EXPECT_EQ(second.get_future().wait_for(kLong), std::future_status::ready) << "nobody has asked for it";
  ASSERT_TRUE(prepared.next(kLong));
}

TEST_F(PreparedInstants, TheNextBeginsWhenOneIsTakenAndWithTheLatest) {
  std::atomic<int> begun{0};
  io::PreparedInstants prepared(*rig_, [&](io::LiveInstant&) { ++begun; });
  source_->deliver(0, 1000000);
  while (begun == 0) std::this_thread::yield();
  for (std::uint64_t k = 2; k <= 4; ++k) source_->deliver(0, k * 1000000);
  std::this_thread::sleep_for(50ms);  // in which a wrong one would prepare another
  EXPECT_EQ(begun, 1);
  std::shared_ptr<io::LiveInstant> instant = prepared.next(kLong);
  ASSERT_TRUE(instant);
  EXPECT_EQ(instant->rig.stamp, 1000000u);
  instant = prepared.next(kLong);
  ASSERT_TRUE(instant);
  EXPECT_EQ(instant->rig.stamp, 4000000u) << "what nobody had time for is old";
}

TEST_F(PreparedInstants, AnErrorComesOutAfterWhatWasPreparedBefore) {
  std::atomic<int> begun{0};
  io::PreparedInstants prepared(*rig_, [&](io::LiveInstant&) {
    if (++begun == 2) throw std::runtime_error("of preparing");
  });
  source_->deliver(0, 1000000);
  ASSERT_TRUE(prepared.next(kLong));
  source_->deliver(0, 2000000);
  while (begun < 2) std::this_thread::yield();
  EXPECT_TRUE(prepared.running()) << "or nobody would hear of it";
  EXPECT_THROW(prepared.next(kLong), std::runtime_error);
}

TEST_F(PreparedInstants, ACameraThatFailsEndsThem) {
  source_->why = "the cable is out";
  source_->runs = false;
  io::PreparedInstants prepared(*rig_, [](io::LiveInstant&) {});
  EXPECT_THROW(prepared.next(kLong), io::InputError);
}

/** \brief What was at hand when the cameras ended, and what came since it was begun, come before the end. */
TEST_F(PreparedInstants, TheLastIsPreparedWhenTheCamerasHaveEnded) {
  std::promise<void> go, begun;
  std::shared_future<void> gone = go.get_future().share();
  std::atomic<int> count{0};
  io::PreparedInstants prepared(*rig_, [&](io::LiveInstant&) {
    if (++count > 1) return;
    begun.set_value();
    gone.wait();
  });
  source_->deliver(0, 1000000);
  begun.get_future().wait();
  source_->deliver(0, 2000000);
  source_->runs = false;
  EXPECT_TRUE(prepared.running());
  EXPECT_EQ(prepared.next(0ms), nullptr);
  go.set_value();
  for (const std::uint64_t stamp : {1000000u, 2000000u}) {
    EXPECT_TRUE(prepared.running());
    const std::shared_ptr<io::LiveInstant> instant = prepared.next(kLong);
    ASSERT_TRUE(instant);
    EXPECT_EQ(instant->rig.stamp, stamp);
  }
  EXPECT_EQ(prepared.next(kLong), nullptr);
  EXPECT_FALSE(prepared.running());
}

TEST_F(PreparedInstants, EndWithOneThatNobodyTakes) {
  std::promise<void> begun;
  io::PreparedInstants prepared(*rig_, [&](io::LiveInstant&) { begun.set_value(); });
  source_->deliver(0, 1000000);
  begun.get_future().wait();
}

}  // namespace
