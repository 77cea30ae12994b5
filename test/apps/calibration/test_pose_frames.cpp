#include "calibration/pose_frames.h"

#include "../recordings/io_fixture.h"
#include "simulation/simulator.h"

#include <fuse_flow/math/confidence.h>

#include <random>
#include <utility>

namespace {

using namespace io_test;
using Numbers = std::vector<std::size_t>;

TEST(SpreadFrames, AreEvenlySpreadAndBeginWithTheFirst) {
  EXPECT_EQ(io::spreadFrames(10, 100), (Numbers{0, 10, 20, 30, 40, 50, 60, 70, 80, 90}));
  EXPECT_EQ(io::spreadFrames(4, 10), (Numbers{0, 2, 5, 7}));
  EXPECT_EQ(io::spreadFrames(1, 7), (Numbers{0}));
}

TEST(SpreadFrames, AreAllWhereThereAreNoMore) {
  EXPECT_EQ(io::spreadFrames(10, 3), (Numbers{0, 1, 2}));
  EXPECT_EQ(io::spreadFrames(3, 3), (Numbers{0, 1, 2}));
  EXPECT_TRUE(io::spreadFrames(10, 0).empty());
}

/** \brief Two cameras that face a wall at 2 m, each with so many times the noise that is expected. */
class Walls : public io::Recording {
 public:
  Walls(std::size_t frames, const std::vector<float>& noise, int width = 424)
      : frames_(frames), cameras_(noise.size()) {
    std::mt19937 random(1);
    std::normal_distribution<float> normal;
    for (std::size_t i = 0; i < noise.size(); ++i) {
      Camera& camera = cameras_[i];
      camera.name = "camera " + std::to_string(i);
      Intrinsics& k = camera.intrinsics;
      k.width = width;
      k.height = 240;
      k.fx = k.fy = 200;
      k.cx = 0.5 * (k.width - 1);
      k.cy = 0.5 * (k.height - 1);
      std::vector<float>& z = depth_.emplace_back(static_cast<std::size_t>(k.width * k.height), 2.0f);
      for (float& value : z) value += noise[i] * axialNoise(NoiseModel{}, 2) * normal(random);
    }
  }
  /** \brief A model of its own for a camera. */
  void setNoise(std::size_t camera, const NoiseModel& model) { cameras_[camera].noise = model; }

  std::string kind() const override { return "test"; }
  std::size_t frameCount() const override { return frames_; }
  const std::vector<Camera>& cameras() const override { return cameras_; }
  std::vector<std::string> inputs() const override { return {}; }
  void read(std::size_t frame, io::LoadedFrame& out) override {
    was_read.push_back(frame);
    out.rig.cameras = cameras_;
    out.rig.views.assign(cameras_.size(), DepthView());
    for (std::size_t i = 0; i < cameras_.size(); ++i)
      if (frame >= first_of_last || i + 1 < cameras_.size())
        out.rig.views[i].depth32 = {depth_[i].data(), cameras_[i].intrinsics.width, cameras_[i].intrinsics.height};
  }

  Numbers was_read;
  std::size_t first_of_last{0};  ///< frame in which the last camera measures anything

 private:
  std::size_t frames_;
  std::vector<Camera> cameras_;
  std::vector<std::vector<float>> depth_;
};

TEST(FramesForPoses, AreTenWhereNoiseIsThatOfSinglePixels) {
  Walls walls(100, {1, 1});
  EXPECT_EQ(io::framesForPoses(walls, {}), io::spreadFrames(10, 100));
  EXPECT_EQ(walls.was_read, (Numbers{0})) << "the first frame shows it";
}

TEST(FramesForPoses, AreFortyWhereOneCameraIsAsNoisyAsThoseThatMatchBlocks) {
  for (const std::vector<float>& noise : {std::vector<float>{4, 1}, std::vector<float>{1, 4}}) {
    Walls walls(100, noise);
    EXPECT_EQ(io::framesForPoses(walls, {}), io::spreadFrames(40, 100));
  }
}

TEST(FramesForPoses, ANoisyCameraThatNamesItsNoiseIsAsNoisy) {
  Walls walls(100, {1, 3});
  walls.setNoise(1, {3 * NoiseModel().floor, 0, 3 * NoiseModel().quadratic});
  EXPECT_EQ(io::framesForPoses(walls, {}), io::spreadFrames(40, 100)) << "though it is what its model says";
}

TEST(FramesForPoses, TheBorderIsThatOfCoarserBlocks) {
  Walls below(100, {1.5f, 1.5f}), above(100, {2.2f, 1});  // coarse_above is 1.8
  EXPECT_EQ(io::framesForPoses(below, {}).size(), 10u);
  EXPECT_EQ(io::framesForPoses(above, {}).size(), 40u);
}

TEST(FramesForPoses, ASimulatedSensorTakesFortyOnlyIfItMatchesBlocks) {
  const std::vector<std::pair<std::string, std::size_t>> sensors{
      {"ideal", 10}, {"structured_light", 10}, {"time_of_flight", 10}, {"active_stereo", 40}};
  for (const auto& [sensor, frames] : sensors) {
    simulation::SimulationOptions options;
    options.scene = "thin";
    options.rig = "ring-1";
    options.sensor = sensor;
    options.color = false;
    simulation::Simulator simulator(options);
    io::LoadedFrame loaded;
    simulator.measure(0, loaded);
    EXPECT_EQ(io::enoughFrames(loaded.rig, {}), frames) << sensor;
  }
}

TEST(FramesForPoses, ACameraThatMeasuresNothingAtFirstIsLookedAtLater) {
  Walls walls(100, {1, 4});
  walls.first_of_last = 15;
  EXPECT_EQ(io::framesForPoses(walls, {}), io::spreadFrames(40, 100));
  EXPECT_EQ(walls.was_read, (Numbers{0, 10, 20}));
}

TEST(FramesForPoses, ACameraThatNeverMeasuresAnythingChangesNothing) {
  Walls walls(100, {1, 4});
  walls.first_of_last = 1000;
  EXPECT_EQ(io::framesForPoses(walls, {}), io::spreadFrames(10, 100));
  EXPECT_EQ(walls.was_read.size(), 10u);
}

TEST(FramesForPoses, AreAllOfAShortRecordingUnseen) {
  Walls walls(10, {4, 4});
  EXPECT_EQ(io::framesForPoses(walls, {}).size(), 10u);
  EXPECT_TRUE(walls.was_read.empty());
  Walls longer(11, {4, 4});
  EXPECT_EQ(io::framesForPoses(longer, {}).size(), 11u);
}

TEST(FramesForPoses, AskWhatPoseEstimationDoesWithTheView) {
  ExtrinsicParameters parameters;
  parameters.coarse_above = 100;
  Walls walls(100, {4, 4});
  EXPECT_EQ(io::framesForPoses(walls, parameters).size(), 10u);
  Walls small(100, {4, 4}, 320);  // its blocks stay as they are
  EXPECT_EQ(io::framesForPoses(small, {}).size(), 10u);
}

}  // namespace
