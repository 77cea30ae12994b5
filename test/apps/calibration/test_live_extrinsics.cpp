#include "calibration/live_extrinsics.h"

#include <fuse_flow/calibration/extrinsic_tracking.h>
#include <fuse_flow/device_error.h>
#include <fuse_flow/recordings/error.h>

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace {

using fuse_flow::DeviceError;
using fuse_flow::RigFrame;
using fuse_flow::TrackedPoses;
namespace io = fuse_flow::io;

/** \brief Where the x of all cameras is: one metre further with each estimate, by the first frame and by each that is pushed. */
class Tracking : public io::PoseTracking {
 public:
  Tracking(double x, std::size_t cameras, int failing_push) : failing_push_(failing_push) {
    poses_->T_world_camera.assign(cameras, Eigen::Isometry3d::Identity());
    moveTo(x);
  }
  bool push(const RigFrame&) override {
    if (pushes_++ == failing_push_) throw DeviceError("fuse_flow::gpu: lost");
    moveTo(poses_->T_world_camera[0].translation().x() + 1);
    ++poses_->updates;
    return true;
  }
  void finish() override {}
  std::shared_ptr<const TrackedPoses> poses() const override { return poses_; }
  void apply(RigFrame& frame) const override {
    for (std::size_t i = 0; i < frame.cameras.size(); ++i) frame.cameras[i].T_world_camera = poses_->T_world_camera[i];
  }

 private:
  void moveTo(double x) {
    for (Eigen::Isometry3d& pose : poses_->T_world_camera) pose.translation().x() = x;
  }
  std::shared_ptr<TrackedPoses> poses_ = std::make_shared<TrackedPoses>();
  int failing_push_, pushes_{0};
};

class Estimation : public io::PoseEstimation {
 public:
  explicit Estimation(bool fails) : fails_(fails) {}
  void addFrame(const RigFrame&) override {
    if (fails_) throw DeviceError("fuse_flow::gpu: out of GPU memory");
  }
  fuse_flow::ExtrinsicResult estimate(const std::vector<Eigen::Isometry3d>& initial) override {
    fuse_flow::ExtrinsicResult result;
    result.T_world_camera = initial;
    for (Eigen::Isometry3d& pose : result.T_world_camera) pose.translation().x() += 1;
    return result;
  }

 private:
  bool fails_;
};

class LiveExtrinsics : public testing::Test {
 protected:
  /** \brief \param failing_push -1: none  \returns the x of each frame's cameras */
  std::vector<double> placed(const std::string& device, bool first_fails, int failing_push) {
    io::PoseMakers make;
    make.estimation = [=](const std::string& on, const fuse_flow::ExtrinsicParameters&) {
      used_.push_back(on);
      return std::make_unique<Estimation>(on != "cpu" && first_fails);
    };
    make.tracking = [=](const std::string& on, const std::vector<fuse_flow::Camera>& cameras, double) {
      used_.push_back(on);
      return std::make_unique<Tracking>(cameras[0].T_world_camera.translation().x(), cameras.size(),
                                        on != "cpu" ? failing_push : -1);
    };
    io::LiveExtrinsics extrinsics(
        device, [this](const std::string& message) { said_.push_back(message); }, make);
    std::vector<double> result;
    for (int k = 0; k < 5; ++k) {
      RigFrame frame;
      frame.cameras.resize(2);
      frame.views.resize(2);
      extrinsics.place(frame);
      result.push_back(frame.cameras[1].T_world_camera.translation().x());
    }
    return result;
  }

  std::vector<std::string> used_, said_;
};

const std::vector<double> kUndisturbed{1, 2, 3, 4, 5};

TEST_F(LiveExtrinsics, ThePosesAreThoseOfTheFramesBefore) {
  EXPECT_EQ(placed("auto", false, -1), kUndisturbed);
  EXPECT_EQ(used_, (std::vector<std::string>{"auto", "auto"}));
  EXPECT_TRUE(said_.empty());
}

TEST_F(LiveExtrinsics, TheCpuGoesOnFromThePosesThatTheGpuFound) {
  EXPECT_EQ(placed("auto", false, 2), kUndisturbed);
  EXPECT_EQ(used_, (std::vector<std::string>{"auto", "auto", "cpu"}));
  ASSERT_EQ(said_.size(), 1u);
  EXPECT_NE(said_[0].find("fuse_flow::gpu: lost"), std::string::npos) << said_[0];
}

TEST_F(LiveExtrinsics, TheCpuBeginsWhereTheGpuCannot) {
  EXPECT_EQ(placed("auto", true, -1), kUndisturbed);
  EXPECT_EQ(used_, (std::vector<std::string>{"auto", "cpu", "cpu"}));
  EXPECT_EQ(said_.size(), 1u);
}

TEST_F(LiveExtrinsics, NothingIsReplacedWithoutAWord) {
  io::PoseMakers make;
  make.estimation = [](const std::string&, const fuse_flow::ExtrinsicParameters&) {
    return std::make_unique<Estimation>(true);
  };
  RigFrame frame;
  frame.cameras.resize(2);
  frame.views.resize(2);
  EXPECT_THROW(io::LiveExtrinsics("auto", {}, make).place(frame), DeviceError);
}

TEST_F(LiveExtrinsics, OneCameraAloneIsRefused) {
  RigFrame frame;
  frame.cameras.resize(1);
  frame.views.resize(1);
  try {
    io::LiveExtrinsics("cpu").place(frame);
    FAIL() << "it was placed";
  } catch (const io::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("must have two or more"), std::string::npos) << error.what();
  }
}

TEST_F(LiveExtrinsics, AGpuThatWasAskedForIsNotReplaced) {
  EXPECT_THROW(placed("gpu", false, 2), DeviceError);
  EXPECT_THROW(placed("gpu", true, -1), DeviceError);
  EXPECT_TRUE(said_.empty());
}

}  // namespace
