#include "../rigs.h"

#include <fuse_flow/calibration/coarse_alignment.h>
#include <fuse_flow/calibration/extrinsic_estimation.h>
#include <fuse_flow/quality/reprojection_quality.h>
#include <fuse_flow/recordings/recording.h>

#include <filesystem>

using namespace fuse_flow;
using namespace scenes;

namespace {

/** \brief Four frames of a hand-held Kinect that act as four cameras, where the recording is there. */
class ExtrinsicsOfARecording : public testing::Test {
 protected:
  void SetUp() override {
    const std::string folder = std::string(FUSE_FLOW_TEST_SHARED_DATA) + "/seven_scenes";
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
    io::RecordingOptions options;
    options.views = "0,60,120,180";
    io::openRecording({folder}, options)->read(0, frame_);
  }

  ExtrinsicResult refine(const std::vector<Eigen::Isometry3d>& initial) {
    ExtrinsicEstimation<PointFused> estimation;
    estimation.addFrame(frame_.rig);
    return estimation.estimate(initial);
  }

  io::LoadedFrame frame_;
};

TEST_F(ExtrinsicsOfARecording, RefinedPosesMakeTheViewsAgreeBetterWithNothingLost) {
  const ExtrinsicResult result = refine(poses(frame_.rig.cameras));
  EXPECT_LT(result.residual, 0.7 * result.residual_before);
  const ReprojectionQuality before = reprojectionQuality(fuse(frame_.rig), frame_.rig);
  for (std::size_t i = 0; i < 4; ++i) frame_.rig.cameras[i].T_world_camera = result.T_world_camera[i];
  const ReprojectionQuality after = reprojectionQuality(fuse(frame_.rig), frame_.rig);
  EXPECT_LT(after.multi_view_error, 0.95 * before.multi_view_error);
  EXPECT_LE(after.violationShare(), before.violationShare());
  EXPECT_GE(after.coverage(), before.coverage() - 0.002);
}

// Not at the same poses: depth that this sensor bends leaves several places to rest, some millimetres apart.
TEST_F(ExtrinsicsOfARecording, FromScratchTheViewsAgreeAsWellAsFromTheGivenPoses) {
  if (scenes::kSanitized) GTEST_SKIP() << "the code of CoarseAlignment";
  CoarseAlignment alignment;
  alignment.addFrame(frame_.rig);
  const CoarseAlignmentResult coarse = alignment.estimate();
  ASSERT_TRUE(coarse.complete());
  const ExtrinsicResult scratch = refine(coarse.T_world_camera), given = refine(poses(frame_.rig.cameras));
  EXPECT_LT(scratch.residual, 1.02 * given.residual);
  for (std::size_t i = 1; i < 4; ++i) {
    const auto besideFirst = [&](const ExtrinsicResult& r) {
      return r.T_world_camera[0].inverse() * r.T_world_camera[i];
    };
    EXPECT_LT(apart(besideFirst(scratch), besideFirst(given)), 0.015) << i;
    EXPECT_LT(turned(besideFirst(scratch), besideFirst(given)), 0.5) << i;
  }
}

}  // namespace
