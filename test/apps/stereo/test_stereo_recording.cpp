#include "simulation/simulator.h"
#include "stereo/stereo_recording.h"

#include <fuse_flow/recordings/error.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace {

using namespace fuse_flow;

/** \brief Things on a table, seen by cameras on an arc, in memory; some of them measure no depth. */
class TableRecording : public io::Recording {
 public:
  explicit TableRecording(std::vector<bool> has_depth) : has_depth_(std::move(has_depth)) {
    simulation::SimulationOptions options;
    options.scene = "table";
    options.rig = "arc-" + std::to_string(std::max<std::size_t>(2, has_depth_.size()));
    options.sensor = "ideal";
    options.scale = 0.2;
    simulator_ = std::make_unique<simulation::Simulator>(options);
    cameras_ = simulator_->cameras();
    cameras_.resize(has_depth_.size());
    dropped_.assign(has_depth_.size(), false);
  }

  std::string kind() const override { return "rig"; }
  std::size_t frameCount() const override { return 2; }
  const std::vector<Camera>& cameras() const override { return cameras_; }
  std::vector<std::string> inputs() const override { return {}; }
  bool hasDepth(std::size_t camera) const override { return has_depth_[camera]; }
  void read(std::size_t frame, io::LoadedFrame& out) override {
    ++reads;
    simulator_->measure(frame, out);
    out.rig.cameras = cameras_;
    out.rig.views.resize(cameras_.size());
    out.images.resize(cameras_.size());
    for (std::size_t k = 0; k < cameras_.size(); ++k) {
      DepthView& view = out.rig.views[k];
      if (black) std::fill(out.images[k].color.data.begin(), out.images[k].color.data.end(), Rgb8{});
      if (!has_depth_[k]) view.depth16 = {};
      if (dropped_[k]) view = {};
    }
  }
  int reads{0};
  bool black{false};
  std::vector<bool> dropped_;
  std::vector<Camera> cameras_;

 private:
  std::vector<bool> has_depth_;
  std::unique_ptr<simulation::Simulator> simulator_;
};

/** \brief Depth is estimated for a table; both are at hand. */
struct Estimated {
  TableRecording* table;
  std::vector<std::string> warnings;
  std::unique_ptr<io::Recording> recording;
  io::LoadedFrame frame;

  explicit Estimated(std::vector<bool> has_depth, io::StereoOptions options = {})
      : Estimated(std::make_unique<TableRecording>(std::move(has_depth)), std::move(options)) {}
  explicit Estimated(std::unique_ptr<TableRecording> made, io::StereoOptions options = {}) : table(made.get()) {
    options.warn = [this](const std::string& line) { warnings.push_back(line); };
    recording = io::withStereo(std::move(made), "table", options);
  }

  io::StereoRecording* stereo() const { return io::stereoOf(recording.get()); }
  bool says(const std::string& words, const std::vector<std::string>& lines) const {
    return std::any_of(lines.begin(), lines.end(),
                       [&](const std::string& line) { return line.find(words) != std::string::npos; });
  }
  bool saysAtFirst(const std::string& words) const { return says(words, recording->warnings()); }
};

std::size_t bytesThatDiffer(const std::vector<float>& a, const std::vector<float>& b) {
  std::size_t count = a.size() == b.size() ? 0 : 1;
  for (std::size_t k = 0; k < std::min(a.size(), b.size()); ++k) count += a[k] == b[k] ? 0 : 1;
  return count;
}

TEST(StereoRecording, GivesTheDepthOfTheTrueSurface) {
  io::StereoOptions options;
  options.parameters.edge_step = 0;  // of so small an image much lies beside an edge
  Estimated estimated({false, false, false, false}, options);
  ASSERT_NE(estimated.stereo(), nullptr);
  EXPECT_EQ(estimated.stereo()->estimatedViews(), 4u);
  EXPECT_TRUE(estimated.saysAtFirst("depth is estimated from the colour images of 4 views"));
  estimated.recording->read(0, estimated.frame);
  EXPECT_NO_THROW(checkRigFrame(estimated.frame.rig));
  const DepthView& view = estimated.frame.rig.views[1];
  ASSERT_TRUE(view.depth32);
  ASSERT_TRUE(view.confidence);
  EXPECT_TRUE(view.color);
  std::size_t sure = 0, right = 0;
  const io::FloatImage& depth = estimated.frame.images[1].depth32;
  io::LoadedFrame truth;
  TableRecording exact({true, true, true, true});
  exact.read(0, truth);
  for (int v = 0; v < depth.height; ++v)
    for (int u = 0; u < depth.width; ++u) {
      if (!(view.confidence.row(v)[u] > 0.5f)) continue;
      const float z = exact.cameras_[1].depth_scale * static_cast<float>(truth.images[1].depth16.at(u, v));
      ++sure;
      right += std::fabs(depth.at(u, v) / z - 1) < 0.03f ? 1 : 0;
    }
  EXPECT_GT(sure, depth.data.size() / 5);
  EXPECT_GT(right, sure * 8 / 10);
  EXPECT_GT(estimated.stereo()->agreeing(), 0.3);
  EXPECT_GT(estimated.stereo()->seconds(), 0);
}

TEST(StereoRecording, LeavesTheDepthOfDepthCamerasAsItWasMeasured) {
  Estimated estimated({true, false, false, true});
  EXPECT_TRUE(estimated.saysAtFirst("depth of 2 of 4 views is estimated from the colour images of 4 views"));
  estimated.recording->read(0, estimated.frame);
  io::LoadedFrame measured;
  estimated.table->read(0, measured);
  EXPECT_EQ(estimated.frame.images[0].depth16.data, measured.images[0].depth16.data);
  EXPECT_TRUE(estimated.frame.rig.views[0].depth16);
  EXPECT_FALSE(estimated.frame.rig.views[0].depth32);
  EXPECT_TRUE(estimated.frame.rig.views[1].depth32);
  EXPECT_FALSE(estimated.stereo()->estimates(0));
  EXPECT_TRUE(estimated.stereo()->estimates(1));
}

TEST(StereoRecording, IsTheRecordingItselfWhereEveryViewHasDepthOrNoneIsWanted) {
  EXPECT_EQ(Estimated({true, true}).stereo(), nullptr);
  io::StereoOptions off;
  off.estimate = false;
  Estimated estimated({false, false}, off);
  EXPECT_EQ(estimated.recording.get(), estimated.table);
}

TEST(StereoRecording, TheCameraOfEstimatedDepthIsThatOfItsColourImages) {
  auto made = std::make_unique<TableRecording>(std::vector<bool>{false, false, true});
  for (Camera& camera : made->cameras_) {
    camera.color.emplace();
    camera.color->intrinsics = camera.intrinsics;
    camera.intrinsics.fx = 7;
    camera.color->T_depth_color = Eigen::Translation3d(0.5, 0, 0);
    camera.T_world_camera = camera.T_world_camera * Eigen::Translation3d(-0.5, 0, 0);
  }
  const std::vector<Camera> separate = made->cameras_;
  Estimated estimated(std::move(made));
  estimated.recording->read(0, estimated.frame);
  const Camera& camera = estimated.recording->cameras()[0];
  EXPECT_FALSE(camera.color);
  EXPECT_EQ(camera.intrinsics.fx, separate[0].color->intrinsics.fx);
  EXPECT_TRUE(camera.T_world_camera.isApprox(separate[0].T_world_camera * separate[0].color->T_depth_color));
  EXPECT_TRUE(sameCalibration(camera, estimated.frame.rig.cameras[0]));
  ASSERT_TRUE(camera.noise) << "it is that of stereo";
  EXPECT_GT(camera.noise->quadratic, 0);
  EXPECT_TRUE(sameCalibration(separate[2], estimated.frame.rig.cameras[2]));
}

TEST(StereoRecording, KeepsWhatItHasEstimatedIfItMay) {
  io::StereoOptions options;
  options.keep_bytes = std::size_t{1} << 20;
  Estimated estimated({false, false}, options);
  estimated.recording->read(0, estimated.frame);
  const std::vector<float> depth = estimated.frame.images[0].depth32.data;
  const std::vector<float> confidence = estimated.frame.images[1].confidence.data;
  const double agreeing = estimated.stereo()->agreeing();
  estimated.recording->read(1, estimated.frame);
  estimated.recording->read(0, estimated.frame);
  EXPECT_EQ(estimated.table->reads, 3);
  EXPECT_EQ(estimated.stereo()->seconds(), 0);
  EXPECT_EQ(estimated.stereo()->agreeing(), agreeing);
  EXPECT_EQ(bytesThatDiffer(estimated.frame.images[0].depth32.data, depth), 0u);
  EXPECT_EQ(bytesThatDiffer(estimated.frame.images[1].confidence.data, confidence), 0u);
  EXPECT_NO_THROW(checkRigFrame(estimated.frame.rig));
}

TEST(StereoRecording, OneColourCameraIsRefusedUnlessOthersHaveDepth) {
  try {
    Estimated({false});
    FAIL();
  } catch (const io::InputError& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find("table: camera 'camera_00' has no depth"), std::string::npos) << message;
    EXPECT_NE(message.find("two or more that see the same"), std::string::npos) << message;
    EXPECT_NE(message.find("--no-stereo"), std::string::npos) << message;
  }
}

TEST(StereoRecording, CamerasThatSeeNothingTogetherAreRefused) {
  auto made = std::make_unique<TableRecording>(std::vector<bool>{false, false});
  made->cameras_[1].T_world_camera.rotate(Eigen::AngleAxisd(3.14159, Eigen::Vector3d::UnitY()));
  EXPECT_THROW(Estimated(std::move(made)), io::InputError);
}

TEST(StereoRecording, AFrameWithOneImageHasNoDepthAndItIsSaidOnce) {
  Estimated estimated({false, false});
  estimated.table->dropped_[0] = true;
  estimated.recording->read(0, estimated.frame);
  estimated.recording->read(1, estimated.frame);
  EXPECT_TRUE(estimated.frame.rig.views[0].missing());
  EXPECT_TRUE(estimated.frame.rig.views[1].missing());
  ASSERT_EQ(estimated.warnings.size(), 1u);
  EXPECT_TRUE(estimated.says("frame 000000: 1 view has a colour image", estimated.warnings)) << estimated.warnings[0];
}

TEST(StereoRecording, ADroppedImageLeavesTheOthers) {
  Estimated estimated({false, false, false});
  estimated.table->dropped_[0] = true;
  estimated.recording->read(0, estimated.frame);
  EXPECT_TRUE(estimated.frame.rig.views[0].missing());
  EXPECT_FALSE(estimated.frame.rig.views[1].missing());
  EXPECT_FALSE(estimated.frame.rig.views[2].missing());
}

TEST(StereoRecording, BlackImagesAreNamed) {
  Estimated estimated({false, false});
  estimated.table->black = true;
  estimated.recording->read(0, estimated.frame);
  ASSERT_EQ(estimated.warnings.size(), 2u);
  EXPECT_TRUE(estimated.says("2 images are black or white: camera_00 (black), camera_01 (black)", estimated.warnings));
  EXPECT_TRUE(estimated.says("another view agrees on the depth of 0 % of the pixels", estimated.warnings));
}

TEST(StereoRecording, TellsWhatItDid) {
  io::StereoOptions options;
  options.parameters.min_depth = 0.5f;
  options.parameters.max_depth = 5;
  Estimated estimated({false, false}, options);
  EXPECT_TRUE(estimated.stereo()->json()["agreeing"].is_null());
  estimated.recording->read(0, estimated.frame);
  const nlohmann::json json = estimated.stereo()->json();
  EXPECT_EQ(json["views"], (nlohmann::json{"camera_00", "camera_01"}));
  EXPECT_EQ(json["min_depth_m"], 0.5f);
  EXPECT_EQ(json["max_depth_m"], 5.0f);
  EXPECT_EQ(json["agreeing"], estimated.stereo()->agreeing());
  EXPECT_NE(estimated.stereo()->summary().find("depth of 2 views was estimated: "), std::string::npos);
}

}  // namespace
