#include "live/played_cameras.h"

#include "../recordings/io_fixture.h"
#include "numbered_rig.h"

#include <atomic>
#include <chrono>
#include <cmath>
#include <mutex>
#include <thread>

namespace {

using namespace live_test;
using io_test::refuses;

/** \brief What a played rig has delivered, in its order. */
struct Played {
  struct View {
    std::size_t camera;
    std::uint64_t stamp;
    std::size_t frame;  ///< by its depth
  };
  std::vector<View> views;
  std::vector<std::string> notices;
  std::string failure;

  std::vector<std::size_t> framesOf(std::size_t camera) const {
    std::vector<std::size_t> frames;
    for (const View& view : views)
      if (view.camera == camera) frames.push_back(view.frame);
    return frames;
  }
};

/** \brief Plays to the end. \param most views, after which it is stopped */
Played play(std::unique_ptr<NumberedRig> rig, io::PlayOptions options, std::size_t most = ~std::size_t{0}) {
  const std::vector<std::size_t> frames = rig->frames();
  io::PlayedCameras cameras(std::move(rig), frames, options);
  Played played;
  std::mutex mutex;
  cameras.start({[&](const io::CameraView& view) {
                   const std::lock_guard<std::mutex> lock(mutex);
                   const std::size_t value = view.images->depth16.data.at(0);
                   for (const std::uint16_t z : view.images->depth16.data) EXPECT_EQ(z, value);
                   EXPECT_EQ(value / 1000, view.camera + 1);
                   played.views.push_back({view.camera, view.stamp, value % 1000});
                 },
                 [&](const std::string& line) {
                   const std::lock_guard<std::mutex> lock(mutex);
                   played.notices.push_back(line);
                 }});
  const auto enough = [&] {
    const std::lock_guard<std::mutex> lock(mutex);
    return played.views.size() >= most;
  };
  while (cameras.running() && !enough()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  cameras.stop();
  played.failure = cameras.failure();
  return played;
}

io::PlayOptions fast() {
  io::PlayOptions options;
  options.speed = 20;
  return options;
}

TEST(PlayedCameras, EveryViewComesOnceInOrderWithTheTimesOfTheRecording) {
  const Played played = play(std::make_unique<NumberedRig>(3, 20), io::PlayOptions());
  ASSERT_EQ(played.views.size(), 60u);
  for (std::size_t k = 0; k < played.views.size(); ++k) {
    EXPECT_EQ(played.views[k].frame, k / 3);
    EXPECT_EQ(played.views[k].camera, k % 3);
    EXPECT_EQ(played.views[k].stamp, 5000000 + 20000 * (k / 3));
  }
  EXPECT_TRUE(played.failure.empty());
}

TEST(PlayedCameras, NothingComesBeforeItsTime) {
  for (const double speed : {1.0, 2.0}) {
    io::PlayOptions options;
    options.speed = speed;
    options.jitter = 0.005;
    io::PlayedCameras cameras(std::make_unique<NumberedRig>(2, 10), NumberedRig(2, 10).frames(), options);
    const auto start = std::chrono::steady_clock::now();
    std::atomic<int> views{0}, early{0};
    cameras.start({[&](const io::CameraView& view) {
                     const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
                     const double due = 0.02 / speed * (view.images->depth16.data[0] % 1000);
                     early += passed.count() < due ? 1 : 0;
                     ++views;
                   },
                   [](const std::string&) {}});
    while (cameras.running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_EQ(views, 20);
    EXPECT_EQ(early, 0);
  }
}

TEST(PlayedCameras, APartHasItsCamerasAloneAtTheTimesOfTheWhole) {
  auto rig = std::make_unique<NumberedRig>(5, 8);
  for (std::size_t frame = 0; frame < 4; ++frame)
    for (const std::size_t camera : {2, 3, 4}) rig->missing.insert({camera, frame});  // they begin later
  io::PlayOptions options;
  options.part = 1;
  options.parts = 2;
  const std::vector<std::size_t> frames = rig->frames();
  io::PlayedCameras cameras(std::move(rig), frames, options);
  ASSERT_EQ(cameras.cameras().size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(cameras.cameras()[k].name, "camera_" + std::to_string(2 + k));
  std::atomic<int> views{0}, wrong{0}, early{0};
  const auto start = std::chrono::steady_clock::now();
  cameras.start({[&](const io::CameraView& view) {
                   const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
                   const std::size_t value = view.images->depth16.data.at(0), frame = value % 1000;
                   ++views;
                   wrong += value / 1000 != view.camera + 3 || view.stamp != 5000000 + 20000 * frame ? 1 : 0;
                   early += passed.count() < 0.02 * static_cast<double>(frame) ? 1 : 0;
                 },
                 [](const std::string&) {}});
  while (cameras.running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  EXPECT_EQ(views, 3 * 4);
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(early, 0) << "it began with the first image of its own";
}

TEST(PlayedCameras, ASpeedMakesCamerasOfAHigherRate) {
  const Played played = play(std::make_unique<NumberedRig>(1, 5), fast());
  ASSERT_EQ(played.views.size(), 5u);
  for (std::size_t k = 0; k < 5; ++k) EXPECT_EQ(played.views[k].stamp, 5000000 + 1000 * k);
}

TEST(PlayedCameras, FramesWithoutTimesAreThirtyASecondWhichIsSaid) {
  auto rig = std::make_unique<NumberedRig>(1, 3);
  rig->stamps = false;
  const io::PlayedCameras cameras(std::make_unique<NumberedRig>(*rig), {0, 1, 2}, {});
  ASSERT_EQ(cameras.warnings().size(), 1u);
  EXPECT_NE(cameras.warnings()[0].find("30 frames a second"), std::string::npos);
  const Played played = play(std::move(rig), io::PlayOptions());
  ASSERT_EQ(played.views.size(), 3u);
  EXPECT_EQ(played.views[0].stamp, 0u);
  EXPECT_EQ(played.views[1].stamp, 33333u);
  EXPECT_EQ(played.views[2].stamp, 66667u);
}

TEST(PlayedCameras, AgainAndAgainItsTimesGoOn) {
  io::PlayOptions options = fast();
  options.loop = true;
  for (const bool preload : {false, true}) {
    options.preload = preload;
    const Played played = play(std::make_unique<NumberedRig>(2, 4), options, 40);
    ASSERT_GE(played.views.size(), 40u);
    for (std::size_t k = 0; k < 40; ++k) {
      EXPECT_EQ(played.views[k].frame, (k / 2) % 4);
      EXPECT_EQ(played.views[k].stamp, 5000000 + 1000 * (k / 2));
    }
  }
}

TEST(PlayedCameras, JitterChangesNoCamerasOrderAndLosesNothing) {
  io::PlayOptions options = fast();
  options.jitter = 0.05;  // fifty periods
  const Played played = play(std::make_unique<NumberedRig>(3, 30), options);
  ASSERT_EQ(played.views.size(), 90u);
  bool mixed = false;
  for (std::size_t camera = 0; camera < 3; ++camera) {
    const std::vector<std::size_t> frames = played.framesOf(camera);
    for (std::size_t k = 0; k < frames.size(); ++k) EXPECT_EQ(frames[k], k);
  }
  for (std::size_t k = 1; k < played.views.size(); ++k)
    mixed = mixed || played.views[k].frame < played.views[k - 1].frame;
  EXPECT_TRUE(mixed) << "one camera's view must come before another's of an earlier frame";
}

TEST(PlayedCameras, LosesTheShareThatItIsToldTheSameInEveryRun) {
  io::PlayOptions options = fast();
  options.drop = 0.25;
  const Played first = play(std::make_unique<NumberedRig>(2, 200), options),
               second = play(std::make_unique<NumberedRig>(2, 200), options);
  EXPECT_EQ(first.framesOf(0), second.framesOf(0));
  EXPECT_EQ(first.framesOf(1), second.framesOf(1));
  EXPECT_NE(first.framesOf(0), first.framesOf(1));
  EXPECT_NEAR(static_cast<double>(first.views.size()), 300, 50);  // five standard deviations
  options.drop = 1;
  EXPECT_TRUE(play(std::make_unique<NumberedRig>(2, 20), options).views.empty());
}

TEST(PlayedCameras, ACameraThatStallsDeliversNothingMeanwhile) {
  io::PlayOptions options;
  options.speed = 10;
  options.stalls = {{1, 0.009, 0.02}};  // frames 5 to 14, 2 ms each
  const Played played = play(std::make_unique<NumberedRig>(2, 30), options);
  EXPECT_EQ(played.framesOf(0).size(), 30u);
  const std::vector<std::size_t> frames = played.framesOf(1);
  ASSERT_EQ(frames.size(), 20u);
  EXPECT_EQ(frames[4], 4u);
  EXPECT_EQ(frames[5], 15u);
  options.stalls[0].camera = 2;
  EXPECT_TRUE(refuses([&] { io::PlayedCameras(std::make_unique<NumberedRig>(2, 3), {0}, options); },
                      {"number 2", "must be under 2"}));
}

TEST(PlayedCameras, ClocksOfTheirOwnAreApartAndDrift) {
  io::PlayOptions options;
  options.speed = 20;
  options.own_clocks = true;
  io::PlayedCameras cameras(std::make_unique<NumberedRig>(2, 3), {0, 1, 2}, options);
  EXPECT_EQ(cameras.clocks(), ClockModel::Separate);
  const Played played = play(std::make_unique<NumberedRig>(2, 400), options);
  std::uint64_t first[2] = {0, 0}, last[2] = {0, 0};
  for (const Played::View& view : played.views) {
    if (view.frame == 0) first[view.camera] = view.stamp;
    if (view.frame == 399) last[view.camera] = view.stamp;
  }
  EXPECT_GT(std::llabs(static_cast<long long>(first[0] - first[1])), 1000000);
  for (const int k : {0, 1}) {
    const double drift = static_cast<double>(last[k] - first[k]) / (1000.0 * 399) - 1;
    EXPECT_LE(std::fabs(drift), 52e-6);
    EXPECT_GT(std::fabs(drift), 5e-6);
  }
}

TEST(PlayedCameras, WhatIsMissingInTheRecordingDoesNotCome) {
  const auto rig = std::make_unique<NumberedRig>(2, 30);
  rig->missing = {{0, 2}, {1, 4}};
  for (std::size_t frame = 8; frame < 30; ++frame) rig->missing.insert({1, frame});
  for (const bool preload : {false, true}) {
    io::PlayOptions options = fast();
    options.preload = preload;
    const Played played = play(std::make_unique<NumberedRig>(*rig), options);
    EXPECT_EQ(played.framesOf(0).size(), 29u);
    EXPECT_EQ(played.framesOf(0)[2], 3u);
    EXPECT_EQ(played.framesOf(1), (std::vector<std::size_t>{0, 1, 2, 3, 5, 6, 7}));
  }
}

TEST(PlayedCameras, SaysWhyItEndsBeforeItsEnd) {
  auto damaged = std::make_unique<NumberedRig>(2, 6);
  damaged->damaged = 3;
  const Played ended = play(std::move(damaged), fast());
  EXPECT_EQ(ended.framesOf(1), (std::vector<std::size_t>{0, 1, 2}));
  EXPECT_NE(ended.failure.find("frame 3 is damaged"), std::string::npos);
  auto moved = std::make_unique<NumberedRig>(2, 6);
  moved->moved = 2;
  EXPECT_NE(play(std::move(moved), fast()).failure.find("'camera_0' is elsewhere"), std::string::npos);
}

TEST(PlayedCameras, CanBeStoppedBeforeAndWhileItPlays) {
  { io::PlayedCameras never(std::make_unique<NumberedRig>(1, 3), {0, 1, 2}, {}); }
  io::PlayOptions slow;
  slow.speed = 0.001;  // twenty seconds a frame
  const Played played = play(std::make_unique<NumberedRig>(1, 3), slow, 1);
  EXPECT_EQ(played.views.size(), 1u);
  EXPECT_TRUE(played.failure.empty());
}

}  // namespace
