#include "../scenes.h"

#include <fuse_flow/calibration/depth_correction_estimation.h>
#include <fuse_flow/calibration/extrinsic_estimation.h>
#include <fuse_flow/quality/reprojection_quality.h>
#include <fuse_flow/recordings/recording.h>

#include <filesystem>

using namespace fuse_flow;
using namespace scenes;

namespace {

/** \brief A hand-held Kinect: frames that were not looked at are put right by the correction that others tell. */
TEST(DepthCorrectionOfARecording, HoldsForOtherFramesOfTheSensor) {
  const std::string folder = std::string(FUSE_FLOW_TEST_SHARED_DATA) + "/seven_scenes";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
  if (kSanitized) GTEST_SKIP() << "the code of DepthCorrectionEstimation";
  const auto read = [&](const char* views, io::LoadedFrame& frame) {
    io::RecordingOptions options;
    options.views = views;
    io::openRecording({folder}, options)->read(0, frame);
  };
  io::LoadedFrame others, frame;
  read("5:200:10", others);
  read("0,60,120,180", frame);
  DepthCorrectionParameters parameters;
  parameters.shared = true;
  DepthCorrectionEstimation estimation;
  estimation.setParameters(parameters);
  estimation.addFrame(others.rig);
  const DepthCorrection correction = estimation.estimate().cameras[0].depth_correction;
  const ReprojectionQuality given = reprojectionQuality(fuse(frame.rig), frame.rig);
  for (Camera& camera : frame.rig.cameras) camera.depth_correction = correction;
  ExtrinsicEstimation<PointFused> extrinsics;
  extrinsics.addFrame(frame.rig);
  const ExtrinsicResult refined = extrinsics.estimate();
  for (std::size_t i = 0; i < 4; ++i) frame.rig.cameras[i].T_world_camera = refined.T_world_camera[i];
  const ReprojectionQuality after = reprojectionQuality(fuse(frame.rig), frame.rig);
  EXPECT_LT(after.multi_view_error, 0.7 * given.multi_view_error);
  EXPECT_LT(after.violationShare(), given.violationShare());
  EXPECT_GT(after.coverage(), given.coverage());
}

}  // namespace
