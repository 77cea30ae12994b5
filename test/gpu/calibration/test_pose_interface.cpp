// What the tools see of the classes that find poses.
#if defined(FUSE_FLOW_TEST_HAS_RECORDINGS)

#include "calibration/poses_by.h"
#include "pose_comparison.h"

#include <fuse_flow/gpu/calibration/extrinsic_tracking.h>

namespace {

using namespace pose_comparison;
using furnished_rig::FurnishedRig;
using furnished_rig::Random;
namespace io = fuse_flow::io;

TEST(GpuPoseInterface, ACalibrationHasThePosesOfTheHost) {
  Random random(91);
  FurnishedRig frame(random, {});
  ExtrinsicParameters parameters;
  parameters.gauge = fuse_flow::Gauge::FirstCamera;
  parameters.samples = 2000;
  io::PoseEstimationBy<HostPoses> host(parameters, 0);
  io::PoseEstimationBy<DevicePoses> device(parameters, 0);
  io::PoseEstimation* const both[] = {&host, &device};
  const Poses initial = frame.disturbed(random);
  for (int t = 0; t < 2; ++t) {
    frame.measure(random);
    for (io::PoseEstimation* estimation : both) estimation->addFrame(frame.rig);
  }
  const ExtrinsicResult expected = both[0]->estimate(initial), result = both[1]->estimate(initial);
  expectSamePoses(expected, result);
  EXPECT_EQ(result.T_world_camera[0].matrix(), initial[0].matrix()) << "held";
  EXPECT_GT(apart(result.T_world_camera[1], initial[1]), 0.005) << "moved";
}

TEST(GpuPoseInterface, PosesFollowThoseOfTheHost) {
  Random random(92);
  FurnishedRig frame(random, {});
  fuse_flow::RigFrame placed = frame.rig;
  const Poses initial = frame.disturbed(random, 0.01, 0.005);
  for (std::size_t i = 0; i < initial.size(); ++i) placed.cameras[i].T_world_camera = initial[i];
  io::PoseTrackingBy<fuse_flow::ExtrinsicTracking<pcl::PointXYZ>> host(placed.cameras, 0.01);
  io::PoseTrackingBy<fuse_flow::ExtrinsicTracking<pcl::PointXYZ, fuse_flow::device::Thrust>> device(placed.cameras,
                                                                                                    0.01);
  io::PoseTracking* const both[] = {&host, &device};
  for (std::size_t k = 0; k < 3; ++k) {
    frame.measure(random);
    Poses poses[2];
    for (std::size_t which = 0; which < 2; ++which) {
      EXPECT_TRUE(both[which]->push(frame.rig));
      both[which]->finish();
      EXPECT_EQ(both[which]->poses()->updates, k + 1);
      both[which]->apply(placed);
      for (const fuse_flow::Camera& camera : placed.cameras) poses[which].push_back(camera.T_world_camera);
    }
    for (std::size_t i = 0; i < initial.size(); ++i) EXPECT_LT(apart(poses[1][i], poses[0][i]), 5e-6) << i;
  }
}

}  // namespace

#endif
