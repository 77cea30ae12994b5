#include "calibration/marker_rig.h"

#include <gtest/gtest.h>

#include <algorithm>
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
          std::vector<MarkerSighting>& sightings, double side_said = kSide) {
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
    std::array<Pixel, 4> corners;
    for (std::size_t k = 0; k < 4; ++k) {
      const Eigen::Vector3f p = (T * Vector3d(kSide * x[k], kSide * y[k], 0)).cast<float>();
      const Pixel pixel = project(camera.color ? camera.color->intrinsics : camera.intrinsics, {p.x(), p.y(), p.z()});
      corners[k] = {pixel.u + error(random), pixel.v + error(random)};
    }
    sighting.points = io::squarePoints(side_said, corners);
    sightings.push_back(sighting);
  }
}

/** \brief Waved once around: it faces each pair of neighbours once. */
std::vector<MarkerSighting> wave(const std::vector<Camera>& cameras, double noise, double side_said = kSide) {
  std::vector<MarkerSighting> sightings;
  for (std::size_t frame = 0; frame < 10; ++frame) {
    const double a = 0.2 + 2 * M_PI * static_cast<double>(frame) / 10;
    const Vector3d direction(std::cos(a), std::sin(a), 0.3 + 0.2 * std::sin(3 * a));
    show(cameras, facing(0.1 * direction, direction), frame, noise, sightings, side_said);
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
  const MarkerRig rig = io::placeByMarkers(forgotten(truth), wave(truth, 0));
  expectPoses(rig, truth, 2e-4, 1e-4);
  EXPECT_LT(rig.residual, 1e-2);
  EXPECT_NEAR(rig.depth_ratio, 1, 1e-3);
  EXPECT_GE(rig.markers, 4u);
}

TEST(MarkerRig, ErrorsOfCornersAverageOverAllMarkers) {
  const std::vector<Camera> truth = around({0, 60, 120, 180, 240, 300});
  const MarkerRig rig = io::placeByMarkers(forgotten(truth), wave(truth, 0.15));
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
  expectPoses(io::placeByMarkers(forgotten(truth), sightings), truth, 0.02, 0.01);
}

TEST(MarkerRig, ColourCamerasOfTheirOwnAreNotTakenForDepthCameras) {
  std::vector<Camera> truth = around({0, 70});
  for (Camera& camera : truth) {
    camera.color = ColorCamera{{1280, 720, 900, 905, 640, 350, {}}, Isometry3d::Identity()};
    camera.color->T_depth_color.translation() = Vector3d(0.05, 0.002, -0.004);
    camera.color->T_depth_color.rotate(Eigen::AngleAxisd(0.03, Vector3d(0.2, 1, 0.1).normalized()));
  }
  expectPoses(io::placeByMarkers(forgotten(truth), wave(truth, 0)), truth, 2e-4, 1e-4);
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
  const MarkerRig rig = io::placeByMarkers(forgotten(truth), sightings);
  expectPoses(rig, truth, 3e-4, 2e-4);
  EXPECT_EQ(rig.T_world_camera[0].matrix(), truth[0].T_world_camera.matrix());
}

TEST(MarkerRig, ACameraThatNoMarkerConnectsStaysAndIsSaid) {
  const std::vector<Camera> truth = around({0, 60, 180});
  std::vector<MarkerSighting> sightings;
  show(truth, facing(Vector3d::Zero(), {std::cos(0.5), std::sin(0.5), 0.3}), 0, 0, sightings);  // two cameras
  show(truth, facing(Vector3d::Zero(), {-1, 0, 0.1}), 1, 0, sightings);                         // the third alone
  const MarkerRig rig = io::placeByMarkers(forgotten(truth), sightings);
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
  EXPECT_FALSE(io::placeByMarkers(forgotten(truth), sightings).placed[1]);
}

TEST(MarkerRig, DepthTellsThatTheSizeIsWrong) {
  const std::vector<Camera> truth = around({0, 90});
  EXPECT_NEAR(io::placeByMarkers(forgotten(truth), wave(truth, 0, 0.8 * kSide)).depth_ratio, 1.25, 0.01);
}

/** \brief A board of 6 by 4 points, 40 mm apart, whose origin is one of its corners, not its middle. */
MarkerSighting boardSighting(const Camera& camera, std::size_t which, const Isometry3d& T_world_board,
                             std::size_t frame) {
  const Isometry3d T = (camera.T_world_camera.inverse() * T_world_board);
  MarkerSighting sighting;
  sighting.camera = which;
  sighting.frame = frame;
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 6; ++column) {
      const Eigen::Vector2d place(0.04 * column, 0.04 * row);
      const Eigen::Vector3f p = (T * Vector3d(place.x(), place.y(), 0)).cast<float>();
      sighting.points.push_back({place, project(camera.intrinsics, {p.x(), p.y(), p.z()})});
    }
  sighting.depth_at = sighting.points[9].place;
  sighting.depth = static_cast<float>((T * Vector3d(sighting.depth_at.x(), sighting.depth_at.y(), 0)).z());
  return sighting;
}

/** \brief A board shown to neighbours in turn, three times each pair. */
std::vector<MarkerSighting> boardShown(const std::vector<Camera>& cameras, double step) {
  std::vector<MarkerSighting> sightings;
  for (std::size_t i = 0; i + 1 < cameras.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const double a = (static_cast<double>(i) + 0.5) * step, tilt = 0.25 * static_cast<double>(k) - 0.2;
      const Vector3d direction(std::cos(a + tilt), std::sin(a + tilt), 0.2 + tilt);
      const Isometry3d T = facing(Vector3d(0.1 * tilt, 0.05, 0.1 * tilt), direction);
      for (const std::size_t camera : {i, i + 1})
        sightings.push_back(boardSighting(cameras[camera], camera, T, 3 * i + k));
    }
  return sightings;
}

constexpr double kStep = 40 * M_PI / 180;

/** \brief Pixels are stored as float, and the lens is undone in float: a few micrometres. */
constexpr double kExact = 1e-5;

TEST(BoardRig, ABoardOfManyPointsPlacesCamerasToMicrometres) {
  const std::vector<Camera> truth = around({0, 40, 80, 120});
  const MarkerRig rig = io::placeByMarkers(forgotten(truth), boardShown(truth, kStep));
  expectPoses(rig, truth, kExact, kExact);
  EXPECT_LT(rig.residual, 1e-3);
  EXPECT_NEAR(rig.depth_ratio, 1, 1e-5);
  EXPECT_EQ(rig.markers, 9u);
  EXPECT_EQ(rig.unusable, 0u);
}

TEST(BoardRig, CamerasNeedNotSeeTheSamePoints) {
  const std::vector<Camera> truth = around({0, 40, 80, 120});
  std::vector<MarkerSighting> sightings = boardShown(truth, kStep);
  for (std::size_t k = 0; k < sightings.size(); ++k) {  // the left half to one, the right half to the next
    auto& points = sightings[k].points;
    const auto hidden = [&](const io::MarkerPoint& p) { return k % 2 == 0 ? p.place.x() > 0.1 : p.place.x() < 0.1; };
    points.erase(std::remove_if(points.begin(), points.end(), hidden), points.end());
    ASSERT_EQ(points.size(), 12u);
  }
  expectPoses(io::placeByMarkers(forgotten(truth), sightings), truth, 10 * kExact, 10 * kExact);
}

TEST(BoardRig, TheOrderOfSightingsAndFramesDoesNotMatter) {
  const std::vector<Camera> truth = around({0, 40, 80, 120});
  std::vector<MarkerSighting> sightings = boardShown(truth, kStep);
  const MarkerRig rig = io::placeByMarkers(forgotten(truth), sightings);
  std::reverse(sightings.begin(), sightings.end());
  for (MarkerSighting& sighting : sightings) {
    sighting.frame = 100 - sighting.frame;
    std::shuffle(sighting.points.begin(), sighting.points.end(), std::mt19937(5));
  }
  const MarkerRig reversed = io::placeByMarkers(forgotten(truth), sightings);
  for (std::size_t i = 0; i < truth.size(); ++i)
    EXPECT_LT((rig.T_world_camera[i].matrix() - reversed.T_world_camera[i].matrix()).norm(), 1e-6) << i;
  expectPoses(reversed, truth, kExact, kExact);
}

TEST(BoardRig, TheOrderOfCamerasDoesNotMatter) {
  const std::vector<Camera> truth = around({0, 40, 80, 120});
  std::vector<MarkerSighting> sightings = boardShown(truth, kStep);
  const std::vector<std::size_t> order{0, 3, 1, 2};  // where each camera goes to
  std::vector<Camera> moved(truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i) moved[order[i]] = truth[i];
  for (MarkerSighting& sighting : sightings) sighting.camera = order[sighting.camera];
  expectPoses(io::placeByMarkers(forgotten(moved), sightings), moved, kExact, kExact);
}

TEST(BoardRig, TooFewPointsOrPointsOnOneLineAreCountedAndLeftOut) {
  const std::vector<Camera> truth = around({0, 40});
  std::vector<MarkerSighting> sightings = boardShown(truth, kStep);
  MarkerSighting few = boardSighting(truth[0], 0, facing(Vector3d::Zero(), {1, 0.3, 0.2}), 50);
  MarkerSighting line = boardSighting(truth[1], 1, facing(Vector3d::Zero(), {1, 0.3, 0.2}), 50);
  few.points.resize(3);
  line.points.resize(6);
  sightings.insert(sightings.begin(), few);
  sightings.push_back(line);
  sightings.push_back(line);
  sightings.back().points.clear();
  const MarkerRig rig = io::placeByMarkers(forgotten(truth), sightings);
  EXPECT_EQ(rig.unusable, 3u);
  EXPECT_EQ(rig.markers, 3u);
  expectPoses(rig, truth, kExact, kExact);
}

TEST(BoardRig, ACornerThatIsWrongCountsLittle) {
  const std::vector<Camera> truth = around({0, 40});
  std::vector<MarkerSighting> sightings = boardShown(truth, kStep);
  sightings[2].points[7].pixel.u += 20;
  const MarkerRig rig = io::placeByMarkers(forgotten(truth), sightings);
  expectPoses(rig, truth, 0.01, 0.005);
  EXPECT_GT(rig.residual, 1) << "and is seen in the residual";
}

TEST(BoardRig, ABoardTakenHalfATurnApartContradictsItself) {
  const std::vector<Camera> truth = around({0, 40, 80});
  std::vector<MarkerSighting> sightings = boardShown(truth, kStep);
  for (MarkerSighting& sighting : sightings)  // one camera counts its corners from the other end in some frames
    if (sighting.camera == 1 && sighting.frame % 2 == 0)
      for (io::MarkerPoint& point : sighting.points) point.place = Eigen::Vector2d(0.2, 0.12) - point.place;
  EXPECT_GT(io::placeByMarkers(forgotten(truth), sightings).residual, 3);
}

TEST(MarkerRig, WithoutAnySightingEveryCameraStays) {
  const MarkerRig rig = io::placeByMarkers(around({0, 60}), {});
  EXPECT_EQ(rig.placed, (std::vector<bool>{true, false}));
  EXPECT_EQ(rig.residual, 0);
  EXPECT_EQ(rig.depth_ratio, 0);
}

}  // namespace
