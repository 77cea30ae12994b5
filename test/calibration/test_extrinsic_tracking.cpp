#include "../rigs.h"

#include <fuse_flow/calibration/extrinsic_tracking.h>

#include <pcl/exceptions.h>
#include <pcl/point_types.h>

#include <atomic>
#include <thread>

using namespace fuse_flow;
using namespace scenes;

namespace {

/** \brief What an estimate would say whose cameras stand at the given poses. */
ExtrinsicResult estimateOf(const std::vector<Eigen::Isometry3d>& found, double deviation = 0.0005) {
  ExtrinsicResult result;
  result.T_world_camera = found;
  for (std::size_t i = 0; i < found.size(); ++i) {
    CameraCorrection c;
    c.neighbours = found.size() - 1;
    c.covariance = deviation * deviation * Eigen::Matrix<double, 6, 6>::Identity();
    result.corrections.push_back(c);
  }
  return result;
}

PoseFilter filterAt(const std::vector<Eigen::Isometry3d>& poses, double deviation = 0.001) {
  PoseFilter filter;
  filter.reset(poses, deviation);
  return filter;
}

TEST(PoseFilter, AveragesEstimatesAndGrowsSure) {
  const std::vector<Eigen::Isometry3d> truth = poses(cornerCameras(4));
  std::vector<Eigen::Isometry3d> start = truth;
  start[2] = moved(start[2], {0.01, 0, 0});
  PoseFilter filter = filterAt(start, 0.02);
  for (int k = 0; k < 60; ++k) {
    std::vector<Eigen::Isometry3d> found = truth;
    found[2] = moved(found[2], {k % 2 ? 0.002 : -0.002, 0, 0});
    EXPECT_TRUE(filter.update(estimateOf(found)).empty());
  }
  EXPECT_LT(apart(filter.poses()[2], truth[2]), 0.0006);
  EXPECT_LT(filter.deviation(2), 0.001);
}

TEST(PoseFilter, OneBadFrameChangesNothing) {
  const std::vector<Eigen::Isometry3d> truth = poses(cornerCameras(4));
  PoseFilter filter = filterAt(truth);
  std::vector<Eigen::Isometry3d> found = truth;
  found[3] = moved(found[3], {0.05, 0.02, 0}, 2);
  EXPECT_TRUE(filter.update(estimateOf(found)).empty());
  EXPECT_TRUE(filter.keptBack(3));
  EXPECT_LT(apart(filter.poses()[3], truth[3]), 1e-9);
  EXPECT_TRUE(filter.update(estimateOf(truth)).empty());
  EXPECT_FALSE(filter.keptBack(3));
}

TEST(PoseFilter, BadFramesThatDisagreeChangeNothingHoweverMany) {
  const std::vector<Eigen::Isometry3d> truth = poses(cornerCameras(4));
  PoseFilter filter = filterAt(truth);
  for (int k = 0; k < 20; ++k) {
    std::vector<Eigen::Isometry3d> found = truth;
    found[3] = moved(found[3], {0.05 * (k % 3 - 1.4), 0.04 * (k % 5 - 2.2), 0});
    EXPECT_TRUE(filter.update(estimateOf(found)).empty());
  }
  EXPECT_LT(apart(filter.poses()[3], truth[3]), 0.001);
}

TEST(PoseFilter, ACameraThatWasBumpedIsFoundAfterThreeEstimates) {
  const std::vector<Eigen::Isometry3d> truth = poses(cornerCameras(4));
  PoseFilter filter = filterAt(truth);
  std::vector<Eigen::Isometry3d> found = truth;
  found[1] = moved(found[1], {0.03, 0, 0.04}, 1.5);
  EXPECT_TRUE(filter.update(estimateOf(found)).empty());
  EXPECT_TRUE(filter.update(estimateOf(found)).empty());
  const std::vector<CameraMotion> events = filter.update(estimateOf(found));
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].camera, 1u);
  EXPECT_NEAR(events[0].translation, 0.05, 1e-6);
  EXPECT_NEAR(events[0].rotation, 1.5 * kDegree, 1e-6);
  EXPECT_LT(apart(events[0].T_new_old * truth[1], found[1]), 1e-9);
  EXPECT_LT(apart(filter.poses()[1], found[1]), 1e-9);
  EXPECT_LT(apart(filter.poses()[0], truth[0]), 1e-9);
}

TEST(PoseFilter, IfAllButTheFirstCameraSeemToMoveTheFirstDid) {
  const std::vector<Eigen::Isometry3d> truth = poses(cornerCameras(4));
  PoseFilter filter = filterAt(truth);
  // The estimate holds camera 0: its own bump shows as the inverse motion of all the others.
  Eigen::Isometry3d bump = Eigen::Isometry3d::Identity();
  bump.translation() = Vector3d(0.05, 0, 0);
  std::vector<Eigen::Isometry3d> found = truth;
  for (std::size_t i = 1; i < found.size(); ++i) found[i] = bump.inverse() * found[i];
  std::vector<CameraMotion> events;
  for (int k = 0; k < 3; ++k) events = filter.update(estimateOf(found));
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].camera, 0u);
  EXPECT_LT(apart(filter.poses()[0], bump * truth[0]), 1e-9);
  EXPECT_LT(apart(filter.poses()[2], truth[2]), 1e-9);
}

TEST(PoseFilter, FollowsASlowDrift) {
  std::vector<Eigen::Isometry3d> truth = poses(cornerCameras(4));
  PoseFilter filter = filterAt(truth);
  for (int k = 0; k < 300; ++k) {
    truth[2] = moved(truth[2], {0.00005, 0, 0}, 0.001);
    EXPECT_TRUE(filter.update(estimateOf(truth)).empty()) << k;
  }
  EXPECT_LT(apart(filter.poses()[2], truth[2]), 0.003) << "of 15 mm";
}

TEST(PoseFilter, ACameraOfWhichAnEstimateSaysNothingStays) {
  const std::vector<Eigen::Isometry3d> truth = poses(cornerCameras(3));
  PoseFilter filter = filterAt(truth);
  ExtrinsicResult estimate = estimateOf(truth);
  estimate.corrections[2].neighbours = 0;
  estimate.T_world_camera[2] = moved(truth[2], {0.001, 0, 0});
  filter.update(estimate);
  EXPECT_EQ(filter.poses()[2].matrix(), truth[2].matrix());
}

TEST(PoseFilter, WrongParametersAreRefused) {
  PoseFilter filter = filterAt(poses(cornerCameras(2)));
  EXPECT_THROW(filter.update(estimateOf(poses(cornerCameras(3)))), pcl::BadArgumentException);
  EXPECT_THROW(filter.reset(poses(cornerCameras(2)), 0), pcl::BadArgumentException);
  for (const auto set : std::vector<void (*)(PoseFilterParameters&)>{
           [](PoseFilterParameters& p) { p.drift = -1; }, [](PoseFilterParameters& p) { p.deviation_scale = 0; },
           [](PoseFilterParameters& p) { p.min_deviation = 0; }, [](PoseFilterParameters& p) { p.gate = 0; },
           [](PoseFilterParameters& p) { p.confirmations = 1; }}) {
    PoseFilterParameters parameters;
    set(parameters);
    EXPECT_THROW(filter.setParameters(parameters), pcl::BadArgumentException);
  }
}

using Tracking = ExtrinsicTracking<pcl::PointXYZ>;

TEST(ExtrinsicTracking, BringsARigRightWhileItRuns) {
  const std::vector<Camera> cameras = cornerCameras(3);
  Scene scene = makeScene(cameras, cornerAndBall());
  scene.rig.cameras[1].T_world_camera = moved(cameras[1].T_world_camera, {0.01, -0.005, 0.01}, 0.5);
  Tracking tracking(scene.rig.cameras);
  for (int k = 0; k < 5; ++k) {
    scene.rig.stamp = static_cast<std::uint64_t>(33333 * (k + 1));
    ASSERT_TRUE(tracking.push(scene.rig));
    tracking.finish();
    tracking.apply(scene.rig);
  }
  const Eigen::Isometry3d relative =
      scene.rig.cameras[0].T_world_camera.inverse() * scene.rig.cameras[1].T_world_camera;
  EXPECT_LT(apart(relative, cameras[0].T_world_camera.inverse() * cameras[1].T_world_camera), 0.001);
  EXPECT_EQ(tracking.poses()->updates, 5u);
  EXPECT_EQ(tracking.poses()->stamp, 5 * 33333u);
}

TEST(ExtrinsicTracking, ABumpedCameraIsToldAndPutRight) {
  std::vector<Camera> cameras = cornerCameras(4);
  Scene scene = makeScene(cameras, cornerAndBall());
  Tracking tracking(cameras, 0.002);
  const auto run = [&](int frames) {
    std::vector<CameraMotion> events;
    for (int k = 0; k < frames; ++k) {
      tracking.push(scene.rig);
      tracking.finish();
      for (const CameraMotion& m : tracking.poses()->moved) events.push_back(m);
    }
    return events;
  };
  EXPECT_TRUE(run(3).empty());
  Camera bumped = cameras[2];
  bumped.T_world_camera = moved(bumped.T_world_camera, {0.03, 0.0, -0.04}, 1.0);
  scene.depth[2] = render(bumped, cornerAndBall());
  scene.attach();
  const std::vector<CameraMotion> events = run(5);
  ASSERT_EQ(events.size(), 1u) << "within five frames";
  EXPECT_EQ(events[0].camera, 2u);
  EXPECT_NEAR(events[0].translation, 0.05, 0.003);
  EXPECT_LT(apart(tracking.poses()->T_world_camera[2], bumped.T_world_camera), 0.002);
}

TEST(ExtrinsicTracking, TheFramesImagesMayChangeWhileItWorks) {
  const std::vector<Camera> cameras = cornerCameras(2);
  Scene scene = makeScene(cameras, cornerAndBall());
  Tracking tracking(cameras, 0.002);
  ASSERT_TRUE(tracking.push(scene.rig));
  for (io::FloatImage& image : scene.depth) std::fill(image.data.begin(), image.data.end(), 0.0f);
  tracking.finish();
  EXPECT_EQ(tracking.poses()->updates, 1u);
  EXPECT_LT(apart(tracking.poses()->T_world_camera[1], cameras[1].T_world_camera), 0.001);
}

TEST(ExtrinsicTracking, ReadersAlwaysSeeOneCompleteSet) {
  const std::vector<Camera> cameras = cornerCameras(2);
  const Scene scene = makeScene(cameras, cornerAndBall());
  Tracking tracking(cameras, 0.002);
  std::atomic<bool> done{false};
  std::thread reader([&] {
    std::size_t newest = 0;
    while (!done) {
      const auto poses = tracking.poses();
      EXPECT_GE(poses->updates, newest);
      EXPECT_EQ(poses->T_world_camera.size(), 2u);
      newest = poses->updates;
      RigFrame copy = scene.rig;
      tracking.apply(copy);
    }
  });
  std::size_t taken = 0;
  for (int k = 0; k < 200 && taken < 4; ++k) {
    taken += tracking.push(scene.rig) ? 1 : 0;
    if (taken > 0 && k % 3 == 0) tracking.finish();
  }
  tracking.finish();
  done = true;
  reader.join();
  EXPECT_EQ(tracking.poses()->updates, taken);
}

TEST(ExtrinsicTracking, SeveralThreadsMayOfferFrames) {
  const std::vector<Camera> cameras = cornerCameras(2);
  const Scene scene = makeScene(cameras, cornerAndBall());
  Tracking tracking(cameras, 0.002);
  std::atomic<std::size_t> taken{0};
  std::vector<std::thread> grabbers;
  for (int t = 0; t < 3; ++t)
    grabbers.emplace_back([&] {
      for (int k = 0; k < 50; ++k) taken += tracking.push(scene.rig) ? 1 : 0;
    });
  for (std::thread& grabber : grabbers) grabber.join();
  tracking.finish();
  EXPECT_GT(taken, 0u);
  EXPECT_EQ(tracking.poses()->updates, taken);  // each frame that was taken is one estimate
}

/** \brief Which of some stamps are taken, each frame being done before the next one comes. */
std::vector<std::uint64_t> takenOf(Tracking& tracking, RigFrame frame, const std::vector<std::uint64_t>& stamps) {
  std::vector<std::uint64_t> taken;
  for (const std::uint64_t stamp : stamps) {
    frame.stamp = stamp;
    if (tracking.push(frame)) taken.push_back(stamp);
    tracking.finish();
  }
  return taken;
}

TEST(ExtrinsicTracking, FramesThatFollowTooSoonAreLeftToTheFusion) {
  using Stamps = std::vector<std::uint64_t>;
  const std::vector<Camera> cameras = cornerCameras(2);
  const Scene scene = makeScene(cameras, cornerAndBall());
  Tracking tracking(cameras, 0.002);
  EXPECT_EQ(tracking.getMinInterval(), 30000u);
  // 90 Hz: every third. The first is taken, however soon after the epoch it comes.
  EXPECT_EQ(takenOf(tracking, scene.rig, {11111, 22222, 33333, 44444, 55555, 66666}), (Stamps{11111, 44444}));
  // What goes back in time, or has no time of its own, is not too soon.
  EXPECT_EQ(takenOf(tracking, scene.rig, {5, 5, 0, 0}), (Stamps{5, 5, 0, 0}));
  // Exactly the interval, and jitter of frames at 30 Hz.
  EXPECT_EQ(takenOf(tracking, scene.rig, {30000, 59999, 60000, 91000, 126000}), (Stamps{30000, 60000, 91000, 126000}));
  tracking.setMinInterval(0);
  EXPECT_EQ(tracking.getMinInterval(), 0u);
  EXPECT_EQ(takenOf(tracking, scene.rig, {126001, 126002}), (Stamps{126001, 126002}));
}

TEST(ExtrinsicTracking, WrongFramesAreRefusedAtOnce) {
  const std::vector<Camera> cameras = cornerCameras(2);
  Tracking tracking(cameras);
  EXPECT_THROW(tracking.push(makeScene(cornerCameras(3), cornerAndBall()).rig), pcl::BadArgumentException);
  ExtrinsicParameters wrong;
  wrong.samples = 0;
  EXPECT_THROW(Tracking(cameras, 0.01, wrong), pcl::BadArgumentException);
}

TEST(ExtrinsicTracking, OneCameraAloneCostsNothing) {
  const Scene scene = makeScene(cornerCameras(1), cornerAndBall());
  ExtrinsicTracking<pcl::PointXYZ> tracking(scene.rig.cameras);
  EXPECT_FALSE(tracking.push(scene.rig));
  tracking.finish();
  EXPECT_EQ(tracking.poses()->updates, 0u);
  EXPECT_EQ(tracking.poses()->T_world_camera[0].matrix(), scene.rig.cameras[0].T_world_camera.matrix());
}

}  // namespace
