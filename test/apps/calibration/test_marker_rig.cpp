#include "calibration/marker_rig.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace {

using namespace fuse_flow;
using Eigen::Isometry3d;
using Eigen::Vector3d;
using io::MarkerRig;
using io::MarkerSighting;

constexpr double kSide = 0.3;

Isometry3d lookingAt(const Vector3d& from, const Vector3d& at) {
  Isometry3d T = Isometry3d::Identity();
  T.linear().col(2) = (at - from).normalized();
  T.linear().col(0) = T.linear().col(2).cross(Vector3d::UnitZ()).normalized();
  T.linear().col(1) = T.linear().col(2).cross(T.linear().col(0));
  T.translation() = from;
  return T;
}

/** \brief On a circle about the origin, degrees apart, all looking at the middle; a wide lens that bends lines. */
std::vector<Camera> around(const std::vector<double>& degrees) {
  std::vector<Camera> cameras;
  for (const double angle : degrees) {
    Camera camera;
    camera.name = "at " + std::to_string(angle);
    camera.intrinsics = {640, 480, 520, 515, 322, 237, {}};
    camera.intrinsics.distortion.k1 = 0.1f;
    camera.intrinsics.distortion.p1 = 0.002f;
    const double a = angle * M_PI / 180;
    camera.T_world_camera = lookingAt({1.9 * std::cos(a), 1.9 * std::sin(a), 0.5}, Vector3d::Zero());
    cameras.push_back(camera);
  }
  return cameras;
}

/** \brief A marker at a place near the middle that faces a direction. */
Isometry3d facing(const Vector3d& at, const Vector3d& direction) { return lookingAt(at, at - direction); }

/** \brief Corners as the cameras that the marker faces see them, each off by noise, pixels. */
void show(const std::vector<Camera>& cameras, const Isometry3d& T_world_marker, std::size_t frame, double noise,
          std::vector<MarkerSighting>& sightings) {
  std::mt19937 random(static_cast<unsigned int>(frame) + 7);
  std::normal_distribution<float> error(0, static_cast<float>(noise));
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const Camera& camera = cameras[i];
    Isometry3d eye = camera.T_world_camera;
    if (camera.color) eye = eye * camera.color->T_depth_color;
    const Isometry3d T = eye.inverse() * T_world_marker;
    if (-T.linear().col(2).dot(T.translation().normalized()) > -0.4) continue;
    MarkerSighting sighting;
    sighting.camera = i;
    sighting.frame = frame;
    sighting.depth = static_cast<float>(T.translation().z());
    const double x[] = {-0.5, 0.5, 0.5, -0.5}, y[] = {0.5, 0.5, -0.5, -0.5};
    for (std::size_t k = 0; k < 4; ++k) {
      const Eigen::Vector3f p = (T * Vector3d(kSide * x[k], kSide * y[k], 0)).cast<float>();
      const Pixel pixel = project(camera.color ? camera.color->intrinsics : camera.intrinsics, {p.x(), p.y(), p.z()});
      sighting.corners[k] = {pixel.u + error(random), pixel.v + error(random)};
    }
    sightings.push_back(sighting);
  }
}

/** \brief Waved once around: it faces each pair of neighbours once. */
std::vector<MarkerSighting> wave(const std::vector<Camera>& cameras, double noise) {
  std::vector<MarkerSighting> sightings;
  for (std::size_t frame = 0; frame < 10; ++frame) {
    const double a = 0.2 + 2 * M_PI * static_cast<double>(frame) / 10;
    const Vector3d direction(std::cos(a), std::sin(a), 0.3 + 0.2 * std::sin(3 * a));
    show(cameras, facing(0.1 * direction, direction), frame, noise, sightings);
  }
  return sightings;
}

/** \brief The first camera where it is, nothing known of the others. */
std::vector<Camera> forgotten(std::vector<Camera> cameras) {
  for (std::size_t i = 1; i < cameras.size(); ++i) cameras[i].T_world_camera.setIdentity();
  return cameras;
}

void expectPoses(const MarkerRig& rig, const std::vector<Camera>& truth, double metres, double radians) {
  ASSERT_EQ(rig.T_world_camera.size(), truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const Isometry3d error = truth[i].T_world_camera.inverse() * rig.T_world_camera[i];
    EXPECT_TRUE(rig.placed[i]) << i;
    EXPECT_LT(error.translation().norm(), metres) << i;
    EXPECT_LT(Eigen::AngleAxisd(error.linear()).angle(), radians) << i;
  }
}

TEST(MarkerRig, FindsTheCamerasThatSawAMarkerTogether) {
  const std::vector<Camera> truth = around({0, 90, 180, 270});
  const MarkerRig rig = io::placeByMarkers(forgotten(truth), wave(truth, 0), kSide);
  expectPoses(rig, truth, 2e-4, 1e-4);
  EXPECT_LT(rig.residual, 1e-2);
  EXPECT_NEAR(rig.depth_ratio, 1, 1e-3);
  EXPECT_GE(rig.markers, 4u);
}

TEST(MarkerRig, ErrorsOfCornersAverageOverAllMarkers) {
  const std::vector<Camera> truth = around({0, 60, 120, 180, 240, 300});
  const MarkerRig rig = io::placeByMarkers(forgotten(truth), wave(truth, 0.15), kSide);
  expectPoses(rig, truth, 0.02, 0.01);
  EXPECT_NEAR(rig.residual, 0.15 * std::sqrt(2), 0.08);
}

TEST(MarkerRig, AMarkerThatOneLookCouldTurnBothWaysIsDecidedByTheOthers) {
  const std::vector<Camera> truth = around({0, 50});
  std::vector<MarkerSighting> sightings = wave(truth, 0.15);
  const std::size_t before = sightings.size();
  // Small in the image and nearly frontal: the mirrored pose fits as well.
  show(truth, facing({-2.5, 0, 0}, {1, 0.25, 0.1}), 10, 0.6, sightings);
  ASSERT_GT(sightings.size(), before);
  expectPoses(io::placeByMarkers(forgotten(truth), sightings, kSide), truth, 0.02, 0.01);
}

TEST(MarkerRig, ColourCamerasOfTheirOwnAreNotTakenForDepthCameras) {
  std::vector<Camera> truth = around({0, 70});
  for (Camera& camera : truth) {
    camera.color = ColorCamera{{1280, 720, 900, 905, 640, 350, {}}, Isometry3d::Identity()};
    camera.color->T_depth_color.translation() = Vector3d(0.05, 0.002, -0.004);
    camera.color->T_depth_color.rotate(Eigen::AngleAxisd(0.03, Vector3d(0.2, 1, 0.1).normalized()));
  }
  expectPoses(io::placeByMarkers(forgotten(truth), wave(truth, 0), kSide), truth, 2e-4, 1e-4);
}

TEST(MarkerRig, TheFirstCameraStaysWhereverItStands) {
  std::vector<Camera> truth = around({0, 90, 180});
  Isometry3d elsewhere = Isometry3d::Identity();
  elsewhere.translation() = Vector3d(5, -3, 1);
  elsewhere.rotate(Eigen::AngleAxisd(1, Vector3d::UnitX()));
  for (Camera& camera : truth) camera.T_world_camera = elsewhere * camera.T_world_camera;
  std::vector<MarkerSighting> sightings;
  for (std::size_t frame = 0; frame < 10; ++frame) {
    const double a = 2 * M_PI * static_cast<double>(frame) / 10;
    show(truth, elsewhere * facing(Vector3d::Zero(), {std::cos(a), std::sin(a), 0.4}), frame, 0, sightings);
  }
  const MarkerRig rig = io::placeByMarkers(forgotten(truth), sightings, kSide);
  expectPoses(rig, truth, 3e-4, 2e-4);
  EXPECT_EQ(rig.T_world_camera[0].matrix(), truth[0].T_world_camera.matrix());
}

TEST(MarkerRig, ACameraThatNoMarkerConnectsStaysAndIsSaid) {
  const std::vector<Camera> truth = around({0, 60, 180});
  std::vector<MarkerSighting> sightings;
  show(truth, facing(Vector3d::Zero(), {std::cos(0.5), std::sin(0.5), 0.3}), 0, 0, sightings);  // two cameras
  show(truth, facing(Vector3d::Zero(), {-1, 0, 0.1}), 1, 0, sightings);                         // the third alone
  const MarkerRig rig = io::placeByMarkers(forgotten(truth), sightings, kSide);
  EXPECT_EQ(rig.placed, (std::vector<bool>{true, true, false}));
  EXPECT_EQ(rig.T_world_camera[2].matrix(), Isometry3d::Identity().matrix());
  EXPECT_EQ(rig.markers, 1u);
}

TEST(MarkerRig, TheSameMarkerAtAnotherInstantIsElsewhere) {
  const std::vector<Camera> truth = around({0, 60});
  std::vector<MarkerSighting> sightings;
  show({truth[0]}, facing({0, 0, 0.1}, {1, 0.3, 0.2}), 0, 0, sightings);
  show({truth[1]}, facing({0.2, 0, 0}, {0.5, 0.8, 0.2}), 1, 0, sightings);
  sightings.back().camera = 1;
  EXPECT_FALSE(io::placeByMarkers(forgotten(truth), sightings, kSide).placed[1]);
}

TEST(MarkerRig, DepthTellsThatTheSizeIsWrong) {
  const std::vector<Camera> truth = around({0, 90});
  EXPECT_NEAR(io::placeByMarkers(forgotten(truth), wave(truth, 0), 0.8 * kSide).depth_ratio, 1.25, 0.01);
}

TEST(MarkerRig, WithoutAnySightingEveryCameraStays) {
  const MarkerRig rig = io::placeByMarkers(around({0, 60}), {}, kSide);
  EXPECT_EQ(rig.placed, (std::vector<bool>{true, false}));
  EXPECT_EQ(rig.residual, 0);
  EXPECT_EQ(rig.depth_ratio, 0);
}

}  // namespace
