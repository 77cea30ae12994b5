#include "../../bench/room.h"
#include "../refusal.h"
#include "../rigs.h"

#include <fuse_flow/calibration/extrinsic_estimation.h>
#include <fuse_flow/impl/calibration/alignment_system.hpp>
#include <fuse_flow/impl/calibration/pose_graph.hpp>
#include <fuse_flow/math/calibration/correspondence.h>

#include <pcl/exceptions.h>
#include <pcl/point_types.h>

#include <random>

using namespace fuse_flow;
using namespace scenes;

namespace {

using Estimation = ExtrinsicEstimation<pcl::PointXYZ>;

ExtrinsicResult estimate(const Scene& scene, const std::vector<Eigen::Isometry3d>& initial,
                         const ExtrinsicParameters& parameters = {}, unsigned int threads = 2) {
  Estimation estimation;
  estimation.setParameters(parameters);
  estimation.setNumberOfThreads(threads);
  estimation.addFrame(scene.rig);
  return estimation.estimate(initial);
}

/** \brief Cameras 1 and 2 some 20 mm and a degree off. */
std::vector<Eigen::Isometry3d> disturbed(const std::vector<Camera>& cameras) {
  std::vector<Eigen::Isometry3d> initial = poses(cameras);
  initial[1] = moved(initial[1], {0.012, -0.011, 0.012}, 1.0, {1, 2, -1});
  initial[2] = moved(initial[2], {-0.01, 0.014, -0.009}, -0.8, {2, 1, 1});
  return initial;
}

TEST(ExtrinsicEstimation, CamerasSomeCentimetresOffComeBack) {
  const std::vector<Camera> cameras = cornerCameras(4);
  const Scene scene = makeScene(cameras, cornerAndBall());
  const ExtrinsicResult result = estimate(scene, disturbed(cameras));
  EXPECT_TRUE(result.converged);
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    EXPECT_LT(apart(result.T_world_camera[i], cameras[i].T_world_camera), 0.0005) << i;
    EXPECT_LT(turned(result.T_world_camera[i], cameras[i].T_world_camera), 0.02) << i;
    EXPECT_TRUE(result.corrections[i].constrained) << i;
  }
  EXPECT_LT(result.residual, 0.2 * result.residual_before);
}

TEST(ExtrinsicEstimation, NoiseLeavesLessThanAMillimetre) {
  const std::vector<Camera> cameras = cornerCameras(4);
  Scene scene = makeScene(cameras, cornerAndBall());
  addNoise(scene, 0.004f);
  const ExtrinsicResult result = estimate(scene, disturbed(cameras));
  for (std::size_t i = 0; i < cameras.size(); ++i)
    EXPECT_LT(apart(result.T_world_camera[i], cameras[i].T_world_camera), 0.001) << i;
}

TEST(ExtrinsicEstimation, WhatIsRightStaysRight) {
  const std::vector<Camera> cameras = cornerCameras(3);
  Scene scene = makeScene(cameras, cornerAndBall());
  addNoise(scene, 0.002f);
  const ExtrinsicResult result = estimate(scene, poses(cameras));
  for (const CameraCorrection& c : result.corrections) {
    EXPECT_LT(c.translation, 0.0008);
    EXPECT_LT(c.rotation, 0.03 * kDegree);
  }
}

// Far surfaces whose noise is as large as what poses are off by: counterparts change with every step, and whole steps go to and fro.
TEST(ExtrinsicEstimation, FarAndNoisyWallsDoNotKeepItFromComingToRest) {
  const bench::Room room(3, 320, 240);
  std::vector<char> memory(room.bytes());
  const RigFrame frame = room.render(memory.data(), 0);
  Estimation estimation;
  estimation.setNumberOfThreads(2);
  estimation.addFrame(frame);
  for (unsigned int trial = 1; trial <= 4; ++trial) {
    std::mt19937 random(trial);
    std::normal_distribution<double> normal;
    const auto direction = [&] { return Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized(); };
    std::vector<Eigen::Isometry3d> initial = poses(frame.cameras);
    for (std::size_t i = 1; i < initial.size(); ++i)
      initial[i] = moved(initial[i], 0.02 * direction(), 1.0, direction());
    const ExtrinsicResult result = estimation.estimate(initial);
    for (std::size_t i = 1; i < initial.size(); ++i)
      EXPECT_LT(apart(result.T_world_camera[i], frame.cameras[i].T_world_camera), 0.008) << trial << ", " << i;
  }
}

/** \brief Three by three blocks of a wall before a camera at the origin, one of them in the middle of the image. */
class Wall {
 public:
  explicit Wall(float depth) : z_(9, depth), rays_(9), normals_(9, Vec3{0, 0, -1}), lumas_(9) {
    image_.width = image_.height = 3;
    image_.z = z_.data();
    image_.rays = rays_.data();
    image_.normals = normals_.data();
    image_.z_pitch = image_.pitch = 3;
    image_.intrinsics.width = image_.intrinsics.height = 3;
    image_.intrinsics.fx = image_.intrinsics.fy = 100;
    image_.intrinsics.cx = image_.intrinsics.cy = 1;
    for (int v = 0; v < 3; ++v)
      for (int u = 0; u < 3; ++u)
        rays_[static_cast<std::size_t>(3 * v + u)] =
            unproject(image_.intrinsics, {static_cast<float>(u), static_cast<float>(v)});
  }
  BlockImage& image() { return image_; }
  /** \brief Grey levels that grow to the right. */
  void paint(float left, float per_block) {
    for (std::size_t k = 0; k < 9; ++k) lumas_[k] = left + per_block * static_cast<float>(k % 3);
    for (const float*& lumas : image_.lumas) lumas = lumas_.data();
    image_.squares = lumas_.data();  // blocks of one pixel
    image_.squares_pitch = 3;
  }

 private:
  std::vector<float> z_;
  std::vector<Ray> rays_;
  std::vector<Vec3> normals_;
  std::vector<float> lumas_;
  BlockImage image_;
};

CameraPlace placeAt(const Eigen::Isometry3d& T_world_camera, const NoiseModel& noise = {}) {
  return {toRigidTransform(T_world_camera), toRigidTransform(T_world_camera.inverse()), noise};
}

// 20 mm of noise in either view, so 28 mm between them: the gate is what is larger, 30 mm or three of these.
TEST(ExtrinsicEstimation, CounterpartsLieWithinTheGateOrThreeDeviationsOfNoise) {
  Wall wall(2.0f);
  wall.image().noise.floor = 0.02f;
  wall.image().noise.quadratic = 0;
  const CameraPlace place = placeAt(Eigen::Isometry3d::Identity(), wall.image().noise);
  AlignmentGates gates{0.03f, 0.0f, 0.7f, 1e9f, 0.0f, 40.0f, false, 0, 1};
  const auto matches = [&](float off) {
    const AlignmentSample sample{{0, 0, 2 + off}, {0, 0, -1}, 0.02f, {}};
    Match match;
    if (!findMatch(place, place, wall.image(), sample, gates, match)) return false;
    EXPECT_NEAR(match.r, -off, 1e-6);
    EXPECT_NEAR(match.per_sigma, 1 / 0.028289, 0.01);  // with half a millimetre of rounding
    return true;
  };
  for (const float sign : {-1.0f, 1.0f}) {
    EXPECT_TRUE(matches(sign * 0.029f));
    EXPECT_FALSE(matches(sign * 0.031f));
    gates.deviations = 3;
    EXPECT_TRUE(matches(sign * 0.084f));
    EXPECT_FALSE(matches(sign * 0.086f));
    gates.distance = 0.2f;
    EXPECT_TRUE(matches(sign * 0.19f));
    EXPECT_FALSE(matches(sign * 0.21f));
    gates.distance = 0.03f;
    gates.deviations = 0;
  }
}

// A wall at 3 m, measured 60 mm too near as often as 60 mm too far. Weighed by what is measured, it would seem 4.8 mm nearer.
TEST(ExtrinsicEstimation, NoiseThatGrowsWithDepthPullsNothingNearer) {
  const float off = 0.06f;
  const AlignmentGates gates{0.5f, 0.0f, 0.7f, 1e9f, 0.0f, 40.0f, false, 0, 1};
  const auto mean = [&](float noise_of_point, float noise_of_wall, bool wall_is_off) {
    double weights = 0, sum = 0;
    for (const float sign : {-1.0f, 1.0f}) {
      Wall wall(wall_is_off ? 3.0f + sign * off : 3.0f);
      wall.image().noise.floor = 0;
      wall.image().noise.quadratic = noise_of_wall / 9;
      const CameraPlace place = placeAt(Eigen::Isometry3d::Identity(), wall.image().noise);
      const float z = wall_is_off ? 3.0f : 3.0f + sign * off;
      const AlignmentSample sample{{0, 0, z}, {0, 0, -1}, noise_of_point * z * z / 9, {}};
      Match match;
      EXPECT_TRUE(findMatch(place, place, wall.image(), sample, gates, match));
      const Correspondence found = geometryOf(match, gates, 1.0f);
      weights += static_cast<double>(found.w);
      sum += static_cast<double>(found.w * found.r);
    }
    return sum / weights;
  };
  EXPECT_NEAR(mean(0.001f, 0.06f, true), 0, 0.0002) << "a noisy wall";
  EXPECT_NEAR(mean(0.06f, 0.0001f, false), 0, 0.0002) << "a noisy point";
}

// The same where the noise of the point grows and that of the wall, which another sensor measures, does not.
TEST(ExtrinsicEstimation, TheNoiseOfAPointGrowsAsItsOwnSensorSays) {
  const AlignmentGates gates{0.5f, 0.0f, 0.7f, 1e9f, 0.0f, 40.0f, false, 0, 1};
  Wall wall(3.0f);
  wall.image().noise = {0.0001f, 0, 0};
  const CameraPlace of_point = placeAt(Eigen::Isometry3d::Identity(), {0, 0, 0.06f / 9});
  const CameraPlace of_wall = placeAt(Eigen::Isometry3d::Identity(), wall.image().noise);
  double weights = 0, sum = 0;
  for (const float z : {2.94f, 3.06f}) {
    const AlignmentSample sample{{0, 0, z}, {0, 0, -1}, 0.06f * z * z / 9, {}};
    Match match;
    ASSERT_TRUE(findMatch(of_point, of_wall, wall.image(), sample, gates, match));
    const Correspondence found = geometryOf(match, gates, 1.0f);
    weights += static_cast<double>(found.w);
    sum += static_cast<double>(found.w * found.r);
  }
  EXPECT_NEAR(sum / weights, 0, 0.0002);
}

// A point 50 mm behind a wall that the other camera measured exactly, seen obliquely: on its ray it is where the wall is.
TEST(ExtrinsicEstimation, ColoursAreComparedWhereBothViewsTogetherPutThePoint) {
  Wall wall(2.0f);
  wall.image().noise.floor = 0.00001f;
  wall.image().noise.quadratic = 0;
  wall.paint(100, 10);
  const CameraPlace j = placeAt(Eigen::Isometry3d::Identity());
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translate(Eigen::Vector3d(-1, 0, 0)).rotate(Eigen::AngleAxisd(std::atan2(1.0, 2.0), Eigen::Vector3d::UnitY()));
  const CameraPlace i = placeAt(T, wall.image().noise);
  const float on_ray = std::sqrt(5.0f);  // from (−1, 0, 0) to (0, 0, 2)
  const Vec3 normal = rotate(i.to_camera, Vec3{0, 0, -1});
  const AlignmentGates gates{0.25f, 0.0f, 0.7f, 1e9f, 0.0f, 400.0f, true, 0, 1};
  const auto difference = [&](float off, float noise, Correspondence& color) {
    const AlignmentSample sample{{0, 0, on_ray + off}, normal, noise, {110, 110, 110, 110, 110}};
    Match match;
    ASSERT_TRUE(findMatch(i, j, wall.image(), sample, gates, match));
    EXPECT_TRUE(colorOf(i, j, wall.image(), sample, match, match.x, 0.0f, gates, color));
  };
  Correspondence noisy, exact, moved;
  difference(0.018f, 0.05f, noisy);
  EXPECT_NEAR(noisy.r, 0, 0.05);
  // It moves along the wall, not through it.
  EXPECT_NEAR(noisy.n.x, 10 * 100 / 2.0f, 5);
  EXPECT_NEAR(noisy.n.z, noisy.n.x * -1 / 2, 5) << "what it does along the normal it does along its ray as well";
  // Where its own depth is the better one it stays: 8 mm to the right are 0.4 blocks of 10 grey levels.
  wall.image().noise.floor = 0.05f;
  difference(0.018f, 0.0f, exact);
  EXPECT_NEAR(exact.r, 10 * (0.018f / on_ray) * 50, 0.3);
  // Both uncertain: half-way, and grey levels tell less.
  wall.image().noise.floor = 0.05f;
  difference(0.018f, 0.05f, moved);
  EXPECT_LT(moved.w, 0.9f * exact.w);
  // 500 grey levels a metre along the wall are 250 along its normal, by the slope of the ray; of 0.05 m each half is left. Beside that
  // 4 of noise, and 10 of a pixel that colour may lie beside.
  EXPECT_NEAR(1 / moved.w, 16 + 100 + 250 * 250 * 0.25f * 2 * 0.05f * 0.05f, 10);
  EXPECT_NEAR(1 / exact.w, 16 + 100, 2);
}

TEST(ExtrinsicEstimation, BlocksAreLargerWhereNeighbouringPixelsErrTogether) {
  ExtrinsicParameters p;
  EXPECT_EQ(blockReduction(p, 848, 1.0f), 2);
  EXPECT_EQ(blockReduction(p, 848, 2.5f), 4);
  EXPECT_EQ(blockReduction(p, 320, 2.5f), 2) << "too few blocks to tell noise from what they show";
  p.coarse_above = 3.0f;
  EXPECT_EQ(blockReduction(p, 848, 2.5f), 2);
}

TEST(ExtrinsicEstimation, TheReportedCorrectionIsWhatWasWrong) {
  const std::vector<Camera> cameras = cornerCameras(3);
  const Scene scene = makeScene(cameras, cornerAndBall());
  std::vector<Eigen::Isometry3d> initial = poses(cameras);
  initial[1] = moved(initial[1], {0.02, 0, 0}, 1.0);
  const ExtrinsicResult result = estimate(scene, initial);
  EXPECT_NEAR(result.corrections[1].translation, 0.02, 0.0005);
  EXPECT_NEAR(result.corrections[1].rotation, 1.0 * kDegree, 0.02 * kDegree);
  EXPECT_LT(apart(result.corrections[1].T_correction * initial[1], cameras[1].T_world_camera), 0.0005);
  EXPECT_EQ(result.corrections[1].neighbours, 2u);
  EXPECT_EQ(result.overlaps.size(), 3u);
}

TEST(ExtrinsicEstimation, TheFirstCameraIsHeldUnlessTheMeanIs) {
  const std::vector<Camera> cameras = cornerCameras(3);
  const Scene scene = makeScene(cameras, cornerAndBall());
  std::vector<Eigen::Isometry3d> initial = poses(cameras);
  initial[0] = moved(initial[0], {0.03, 0, 0});
  EXPECT_EQ(estimate(scene, initial).corrections[0].translation, 0.0);

  ExtrinsicParameters mean;
  mean.gauge = Gauge::Mean;
  const ExtrinsicResult result = estimate(scene, initial, mean);
  EXPECT_NEAR(result.corrections[0].T_correction.translation().x(), -0.02, 0.002) << "two thirds of the error";
  EXPECT_NEAR(result.corrections[1].T_correction.translation().x(), 0.01, 0.002) << "the rest";
  const Eigen::Isometry3d relative = result.T_world_camera[0].inverse() * result.T_world_camera[1];
  EXPECT_LT(apart(relative, cameras[0].T_world_camera.inverse() * cameras[1].T_world_camera), 0.0005);
}

class ExtrinsicsOfOnePlane : public testing::TestWithParam<int> {};

// A few very wrong normals count in the information of the data, but not in the median that estimates the information of noise: with 320
// columns, a slide seemed observable.
TEST_P(ExtrinsicsOfOnePlane, CamerasMoveOntoItButNotAlongIt) {
  const std::vector<Camera> cameras = cameraRow(2, GetParam(), 3 * GetParam() / 4, 0.94 * GetParam());
  Scene scene = makeScene(cameras, plane({0, 0, 1}, 1.5));
  addNoise(scene, 0.002f);
  std::vector<Eigen::Isometry3d> initial = poses(cameras);
  initial[1] = moved(initial[1], {0.02, 0.01, 0.015}, 1.0, Vector3d::UnitX());
  const ExtrinsicResult result = estimate(scene, initial);
  const Vector3d error = result.T_world_camera[1].translation() - cameras[1].T_world_camera.translation();
  // Turning the camera back about the scene's centre moves it a little; what it was slid by stays.
  EXPECT_NEAR(error.x(), 0.02, 0.003);
  const Vector3d normal =
      result.T_world_camera[1].linear() * cameras[1].T_world_camera.linear().transpose() * Vector3d::UnitZ();
  EXPECT_LT(std::acos(std::min(1.0, normal.z())) / kDegree, 0.05) << "the plane is where the other camera has it";
  EXPECT_FALSE(result.corrections[1].constrained);
  ASSERT_EQ(result.corrections[1].free_directions.size(), 3u) << "two slides and a turn";
  for (const auto& twist : result.corrections[1].free_directions) {
    EXPECT_LT(std::abs(twist[2]), 0.1) << "not out of the plane";
    EXPECT_LT(std::hypot(twist[3], twist[4]), 0.1) << "not tilting it";
  }
}

INSTANTIATE_TEST_SUITE_P(Widths, ExtrinsicsOfOnePlane, testing::Values(160, 320, 640));

// As poses in files are: what saw only a plane came out as no number.
TEST(ExtrinsicEstimation, RotationsMayBeRounded) {
  const std::vector<Camera> cameras = cameraRow(3, 160, 120, 150);
  Scene scene = makeScene(cameras, plane({0, 0, 1}, 1.5));
  scene.rig.views[2] = {};
  std::vector<Eigen::Isometry3d> initial = poses(cameras);
  for (Eigen::Isometry3d& T : initial) {
    T = Eigen::AngleAxisd(0.3, Vector3d(1, 2, 3).normalized()) * T;
    T.linear() = (1e4 * T.linear().array()).round() / 1e4;
  }
  const ExtrinsicResult result = estimate(scene, initial);
  EXPECT_EQ(result.corrections[1].free_directions.size(), 3u);
  EXPECT_LT(apart(result.T_world_camera[1], initial[1]), 0.001);
  EXPECT_LT((result.T_world_camera[1].linear() - initial[1].linear()).norm(), 0.001);
  EXPECT_EQ(result.T_world_camera[2].matrix(), initial[2].matrix()) << "saw nothing";
}

// A wall that is painted evenly, in images that are noisy: their gradients are noise, and seemed to tell a slide to a fifth of a millimetre.
TEST(ExtrinsicEstimation, NoiseOfTheImagesTellsNothing) {
  const std::vector<Camera> cameras = cameraRow(2, 320, 240, 275);
  for (const double noise : {0.5, 2.0, 8.0}) {
    Scene scene = makeScene(cameras, plane({0, 0, 1}, 1.5));
    addNoise(scene, 0.0005f);
    std::mt19937 random(4);
    std::normal_distribution<double> grey(128, noise);
    paintWorld(scene, [&](const Vector3d&) { return std::clamp(grey(random), 0.0, 255.0); });
    std::vector<Eigen::Isometry3d> initial = poses(cameras);
    initial[1] = moved(initial[1], {0.02, 0.01, 0.01});
    const ExtrinsicResult result = estimate(scene, initial);
    const Vector3d error = result.T_world_camera[1].translation() - cameras[1].T_world_camera.translation();
    EXPECT_NEAR(error.x(), 0.02, 0.001) << noise;
    EXPECT_NEAR(error.y(), 0.01, 0.001) << noise;
    EXPECT_NEAR(error.z(), 0, 0.001) << noise;
    EXPECT_EQ(result.corrections[1].free_directions.size(), 3u) << noise;
  }
}

// A small difference in brightness looks like a small motion, so even shading gives no information. Without this, cameras moved two thirds
// of the way, with a claimed deviation of a millimetre.
TEST(ExtrinsicEstimation, EvenShadingTellsNoSlide) {
  const std::vector<Camera> cameras = cameraRow(2, 320, 240, 275);
  Scene scene = makeScene(cameras, plane({0, 0, 1}, 1.5));
  addNoise(scene, 0.002f);
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 0.5);
  paintWorld(scene, [&](const Vector3d& x) { return std::clamp(128 + 60 * x.x() + noise(random), 0.0, 255.0); });
  std::vector<Eigen::Isometry3d> initial = poses(cameras);
  initial[1] = moved(initial[1], {0.02, 0.01, 0.01});
  const ExtrinsicResult result = estimate(scene, initial);
  const Vector3d error = result.T_world_camera[1].translation() - cameras[1].T_world_camera.translation();
  EXPECT_LT((error - Vector3d(0.02, 0.01, 0)).norm(), 0.001) << 1e3 * error.transpose();
  EXPECT_FALSE(result.corrections[1].constrained);
}

TEST(ExtrinsicEstimation, ColourTellsWhatAPlaneDoesNot) {
  const std::vector<Camera> cameras = cameraRow(2, 160, 120, 150);
  Scene scene = makeScene(cameras, plane({0, 0, 1}, 1.5));
  addNoise(scene, 0.002f);
  paintWorld(scene, [](const Vector3d& x) {
    return 128 + 50 * std::sin(17 * x.x() + 3 * x.y()) + 50 * std::sin(13 * x.y() - 2 * x.x());
  });
  std::vector<Eigen::Isometry3d> initial = poses(cameras);
  initial[1] = moved(initial[1], {0.02, 0.01, 0.0});
  const ExtrinsicResult with = estimate(scene, initial);
  EXPECT_LT(apart(with.T_world_camera[1], cameras[1].T_world_camera), 0.003);
  EXPECT_TRUE(with.corrections[1].constrained);
  ExtrinsicParameters depth_alone;
  depth_alone.use_color = false;
  EXPECT_GT(apart(estimate(scene, initial, depth_alone).T_world_camera[1], cameras[1].T_world_camera), 0.015);
}

TEST(ExtrinsicEstimation, APatternThatRepeatsItselfIsNotTakenForItsNeighbour) {
  const std::vector<Camera> cameras = cameraRow(2, 160, 120, 150);
  Scene scene = makeScene(cameras, plane({0, 0, 1}, 1.5));
  addNoise(scene, 0.002f);
  const double often = 2 * M_PI / 0.1, seldom = 2 * M_PI / 1.1;
  paintWorld(scene, [&](const Vector3d& x) {
    return 128 + 30 * (std::sin(often * x.x()) + std::sin(often * x.y())) +
           30 * (std::sin(seldom * x.x()) + std::sin(seldom * x.y()));
  });
  std::vector<Eigen::Isometry3d> initial = poses(cameras);
  initial[1] = moved(initial[1], {0.06, -0.055, 0.0});  // nearer to the next stripe than to the right one
  const ExtrinsicResult result = estimate(scene, initial);
  EXPECT_LT(apart(result.T_world_camera[1], cameras[1].T_world_camera), 0.003);
}

// Stripes of 6 pixels, blocks of 2: between two blocks grey levels turn by more than a slope tells.
TEST(ExtrinsicEstimation, TexturesAsFineAsBlocksAreComparedBetweenThem) {
  const Camera camera = cameraRow(1, 160, 120, 150)[0];
  Scene scene = makeScene({camera}, plane({0, 0, 1}, 1.5));
  scene.paint({0, 0, 0});
  const auto stripes = [](double u) { return std::sin(2 * M_PI * u / 6); };
  for (int v = 0; v < 120; ++v)
    for (int u = 0; u < 160; ++u) {
      const auto level = static_cast<std::uint8_t>(std::lround(128 + 60 * stripes(u)));
      scene.color[0].at(u, v) = {level, level, level};
    }
  host::AlignmentSystem system;
  system.add(scene.rig, {});
  const BlockImage& image = system.view(0, 0).image();
  ASSERT_EQ(image.reduction, 2);
  const CameraPlace place = placeAt(Eigen::Isometry3d::Identity());
  const AlignmentGates gates{0.25f, 0.0f, 0.7f, 1e9f, 0.0f, 40.0f, true, 0, 1};
  for (double u = 60; u < 72; u += 0.1) {
    // The mean of two pixels about any place between them.
    const auto luma = static_cast<float>(128 + 60 * stripes(u) * std::cos(M_PI / 6));
    const Vec3 p = pointOnRay(unproject(image.intrinsics, {static_cast<float>(u), 60.0f}), 1.5f);
    const AlignmentSample sample{p, {0, 0, -1}, 0.001f, {luma, luma, luma, luma, luma}};
    Match match;
    Correspondence color;
    ASSERT_TRUE(findMatch(place, place, image, sample, gates, match));
    ASSERT_TRUE(colorOf(place, place, image, sample, match, match.x, 0.0f, gates, color));
    EXPECT_NEAR(color.r, 0, 8) << u;  // blocks alone: up to 28
  }
}

// Colour can be a pixel beside its depth: a steep grey edge determines a place to a pixel, at any contrast.
TEST(ExtrinsicEstimation, ColourTellsAPlaceToAPixelAtBest) {
  const CameraPlace place = placeAt(Eigen::Isometry3d::Identity());
  const AlignmentGates gates{0.25f, 0.0f, 0.7f, 1e9f, 0.0f, 1e6f, true, 0, 1};
  for (const float slope : {1.0f, 10.0f, 100.0f}) {
    Wall wall(2.0f);
    wall.paint(0, slope);
    const AlignmentSample sample{{0, 0, 2}, {0, 0, -1}, 0.001f, {slope, slope, slope, slope, slope}};
    Match match;
    Correspondence color;
    ASSERT_TRUE(findMatch(place, place, wall.image(), sample, gates, match));
    ASSERT_TRUE(colorOf(place, place, wall.image(), sample, match, match.x, 0.0f, gates, color));
    const float per_pixel = std::sqrt(color.w) * slope;  // pixels are worth so many standard deviations
    EXPECT_LT(per_pixel, 1.0f) << slope;
    if (slope > 10) {
      EXPECT_NEAR(per_pixel, 1.0f, 0.01f);
    }
  }
}

// What is painted beside its depth is so in both images.
TEST(ExtrinsicEstimation, ColourWeighsAsMuchWhicheverImageIsSteep) {
  const CameraPlace place = placeAt(Eigen::Isometry3d::Identity());
  const AlignmentGates gates{0.25f, 0.0f, 0.7f, 1e9f, 0.0f, 1e6f, true, 0, 1};
  const auto weight = [&](const LumaSlope& own, float others) {
    Wall wall(2.0f);
    wall.paint(0, others);
    AlignmentSample sample{{0, 0, 2}, {0, 0, -1}, 0.001f, {others, others, others, others, others}};
    sample.slope[0] = own;
    Match match;
    Correspondence color;
    EXPECT_TRUE(findMatch(place, place, wall.image(), sample, gates, match));
    EXPECT_TRUE(colorOf(place, place, wall.image(), sample, match, match.x, 0.0f, gates, color));
    return color.w;
  };
  const float both = weight({30, 0}, 30);
  EXPECT_NEAR(weight({30, 0}, 5), weight({5, 0}, 30), 1e-3f * both);
  EXPECT_NEAR(weight({0, 30}, 5), weight({5, 0}, 30), 1e-3f * both) << "in any direction";
  EXPECT_NEAR(both / weight({0, 0}, 30), 0.5f, 0.01f);
}

TEST(ExtrinsicEstimation, SamplesKnowTheirDepthAsSmoothed) {
  const std::vector<Camera> cameras = cameraRow(1, 160, 120, 150);
  Scene scene = makeScene(cameras, plane({0, 0, 1}, 1.5));
  addNoise(scene, 0.004f);
  host::AlignmentSystem system;
  system.add(scene.rig, {});
  system.sample(poses(cameras), 2000);
  const RigidTransform to_world = toRigidTransform(cameras[0].T_world_camera);
  double measured = 0, smoothed = 0;
  for (const AlignmentSample& sample : system.samples(0, 0)) {
    measured += std::pow((to_world * sample.p).z - 1.5, 2);
    smoothed += std::pow((to_world * (sample.smooth_ratio * sample.p)).z - 1.5, 2);
  }
  EXPECT_GT(measured, 0);
  EXPECT_LT(smoothed, measured / 4);
}

// Noise moves the place at which grey levels are compared, and nothing of what they weigh: else what seems near would weigh more.
TEST(ExtrinsicEstimation, ColourWeighsAsMuchWhicheverWayDepthIsWrong) {
  std::vector<Camera> cameras = cameraRow(2, 160, 120, 150);
  cameras[1].T_world_camera.pretranslate(Vector3d(0.6, 0, 0));
  Scene scene = makeScene(cameras, plane({0, 0, 1}, 1.5));
  ExtrinsicParameters parameters;
  parameters.noise.floor = 0.1f;
  host::AlignmentSystem system;
  system.add(scene.rig, parameters);
  system.sample(poses(cameras), 3000);
  BlockImage other = system.view(0, 1).image();
  std::vector<float> grey;  // of one slope everywhere
  for (int v = 0; v < other.height; ++v)
    for (int u = 0; u < other.width; ++u) grey.push_back(10 + 2.0f * static_cast<float>(u) + static_cast<float>(v));
  for (const float*& lumas : other.lumas) lumas = grey.data();
  ASSERT_EQ(other.pitch, other.width);
  const CameraPlace first = placeAt(cameras[0].T_world_camera, parameters.noise),
                    second = placeAt(cameras[1].T_world_camera, parameters.noise);
  const AlignmentGates gates{0.5f, 3.0f, 0.7f, 1e9f, 0.0f, 1e9f, true, 1, 1};
  const auto colour = [&](const AlignmentSample& sample, Correspondence& color) {
    Match match;
    return findMatch(first, second, other, sample, gates, match) &&
           colorOf(first, second, other, sample, match, match.x, 0.0f, gates, color);
  };
  const auto wrongBy = [](const AlignmentSample& sample, float factor) {
    AlignmentSample off = sample;
    off.p = factor * sample.p;
    off.smooth_ratio = sample.smooth_ratio / factor;
    for (float& luma : off.luma) luma = 100;
    return off;
  };
  int compared = 0;
  for (const AlignmentSample& sample : system.samples(0, 0)) {
    Correspondence near, far;
    if (!colour(wrongBy(sample, 0.96f), near) || !colour(wrongBy(sample, 1.04f), far)) continue;
    ++compared;
    ASSERT_NEAR(near.w / far.w, 1, 0.01f) << sample.p.x << ", " << sample.p.y;
    ASSERT_NEAR(near.n.x / far.n.x, 1, 0.01f) << sample.p.x << ", " << sample.p.y;
  }
  EXPECT_GT(compared, 100);
}

// Seen by cameras of other focal lengths, one of them on its side, on a plane that both see from aside.
TEST(ExtrinsicEstimation, BothImagesShowTheSameGradientAtTheSamePlace) {
  std::vector<Camera> cameras = cameraRow(2, 200, 200, 200);
  cameras[1].intrinsics.fx = cameras[1].intrinsics.fy = 260;
  cameras[1].T_world_camera.rotate(Eigen::AngleAxisd(1.2, Vector3d::UnitZ()));
  Scene scene = makeScene(cameras, plane({0.36, -0.48, 0.8}, 1.2));
  paintWorld(scene, [](const Vector3d& x) { return 128 + 30 * std::sin(14 * x.x()) + 30 * std::sin(11 * x.y()); });
  host::AlignmentSystem system;
  system.add(scene.rig, {});
  system.sample(poses(cameras), 3000);
  for (const std::size_t scale : {0u, 1u, 2u}) {
    const AlignmentGates gates{0.1f, 3.0f, 0.7f, 1e9f, 0.0f, 40.0f, true, scale, 1};
    system.findNeighbours(poses(cameras), gates, 1);
    system.evaluate(poses(cameras), 1.0, gates);
    ASSERT_EQ(system.pairs().size(), 2u);
    for (const host::PairSums& pair : system.pairs()) {
      const host::ColorInformation color(pair.color);
      ASSERT_GT(pair.color.count, 500);
      EXPECT_LT((color.shared - color.all).norm(), 0.1 * color.all.norm()) << scale << ": " << pair.i << ", " << pair.j;
    }
  }
}

TEST(ExtrinsicEstimation, GreyLevelsThatDifferByMoreThanTheyShouldTellLess) {
  const std::vector<Camera> cameras = cameraRow(2, 160, 120, 150);
  Scene scene = makeScene(cameras, plane({0, 0, 1}, 1.5));
  paintWorld(scene, [](const Vector3d& x) { return 128 + 30 * std::sin(8 * x.x()) + 30 * std::sin(7 * x.y()); });
  const auto trust = [&] {
    host::AlignmentSystem system;
    system.add(scene.rig, {});
    system.sample(poses(cameras), 2000);
    AlignmentGates gates{0.1f, 3.0f, 0.7f, 1e9f, 0.0f, 40.0f, true, 0, 1};
    system.findNeighbours(poses(cameras), gates, 1);
    system.evaluate(poses(cameras), 1.0, gates);
    EXPECT_EQ(system.pairs().size(), 2u);
    return system.pairs()[0].color_trust;
  };
  EXPECT_EQ(trust(), 1.0);
  std::mt19937 random(3);
  std::normal_distribution<float> normal(0.0f, 12.0f);
  constexpr int patch = 8;  // pixels of one shade
  for (int v = 0; v < 120; v += patch)
    for (int u = 0; u < 160; u += patch) {
      const float shade = normal(random);
      for (int dv = 0; dv < patch; ++dv)
        for (int du = 0; du < patch; ++du) {
          Rgb8& c = scene.color[1].at(u + du, v + dv);
          c.r = c.g = c.b = static_cast<std::uint8_t>(std::clamp(static_cast<float>(c.r) + shade, 0.0f, 255.0f));
        }
    }
  EXPECT_LT(trust(), 0.5);
  EXPECT_GT(trust(), 0.05);
}

TEST(ExtrinsicEstimation, NoiseThatNeighboursShareMakesItLessSure) {
  const std::vector<Camera> cameras = cornerCameras(3);
  Scene independent = makeScene(cameras, cornerAndBall()), shared = makeScene(cameras, cornerAndBall());
  std::mt19937 random(7);
  std::normal_distribution<float> normal(0.0f, 0.004f);
  constexpr int patch = 16;  // pixels
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    std::vector<float> of_patch;
    for (int k = 0; k < 10 * 8; ++k) of_patch.push_back(normal(random));
    for (int v = 0; v < 120; ++v)
      for (int u = 0; u < 160; ++u) {
        independent.depth[i].at(u, v) += normal(random);
        shared.depth[i].at(u, v) += of_patch[static_cast<std::size_t>(v / patch * 10 + u / patch)];
      }
  }
  independent.attach();
  shared.attach();
  const ExtrinsicResult sure = estimate(independent, poses(cameras)), unsure = estimate(shared, poses(cameras));
  for (std::size_t i = 1; i < cameras.size(); ++i) {
    const auto error = [&](const ExtrinsicResult& r) { return apart(r.T_world_camera[i], cameras[i].T_world_camera); };
    EXPECT_GT(unsure.corrections[i].translation_deviation, 2 * sure.corrections[i].translation_deviation) << i;
    EXPECT_LT(error(sure), 4 * sure.corrections[i].translation_deviation) << i;
    EXPECT_LT(error(unsure), 4 * unsure.corrections[i].translation_deviation) << i;
  }
}

TEST(ExtrinsicEstimation, LargerBlocksAverageNoiseThatNeighboursShare) {
  const std::vector<Camera> cameras = cameraRow(3, 480, 360, 450);
  Scene scene = makeScene(cameras, cornerAndBall());
  const NoiseModel kinect;
  std::mt19937 random(7);
  std::normal_distribution<float> normal;
  constexpr int patch = 3;  // pixels
  for (io::FloatImage& image : scene.depth)
    for (int v = 0; v < image.height; v += patch)
      for (int u = 0; u < image.width; u += patch) {
        const float deviations = 3 * normal(random);
        for (int dv = 0; dv < patch; ++dv)
          for (int du = 0; du < patch; ++du) {
            float& z = image.at(u + du, v + dv);
            z += deviations * axialNoise(kinect, z);
          }
      }
  scene.attach();
  const auto error = [&](float coarse_above) {
    ExtrinsicParameters p;
    p.coarse_above = coarse_above;
    double sum = 0;
    for (const std::vector<Eigen::Isometry3d>& start : {poses(cameras), disturbed(cameras)}) {
      const ExtrinsicResult result = estimate(scene, start, p);
      for (std::size_t i = 1; i < cameras.size(); ++i)
        sum += apart(result.T_world_camera[i], cameras[i].T_world_camera);
    }
    return sum;
  };
  EXPECT_LT(error(1.8f), 0.6 * error(1000.0f));
}

TEST(ExtrinsicEstimation, ACameraBrighterThanTheOtherIsNoHindrance) {
  const std::vector<Camera> cameras = cameraRow(2, 160, 120, 150);
  Scene scene = makeScene(cameras, plane({0, 0, 1}, 1.5));
  paintWorld(scene, [](const Vector3d& x) { return 110 + 45 * std::sin(17 * x.x()) + 45 * std::sin(13 * x.y()); });
  for (Rgb8& c : scene.color[1].data) c.r = c.g = c.b = static_cast<std::uint8_t>(c.r + 15);
  std::vector<Eigen::Isometry3d> initial = poses(cameras);
  initial[1] = moved(initial[1], {0.015, -0.01, 0.0});
  EXPECT_LT(apart(estimate(scene, initial).T_world_camera[1], cameras[1].T_world_camera), 0.003);
}

TEST(ExtrinsicEstimation, CamerasWithoutOverlapStayAndSaySo) {
  std::vector<Camera> cameras = cornerCameras(3);
  cameras[2] = lookAt({0, 0, -1}, {0, 0, -3}, 160, 120, 150);  // the other way
  const Scene scene =
      makeScene(cameras, nearest({cornerAndBall(), plane({0, 0, 1}, -3.0), sphere({0.2, 0.1, -2.3}, 0.3)}));
  std::vector<Eigen::Isometry3d> initial = poses(cameras);
  initial[1] = moved(initial[1], {0.01, 0, 0});
  initial[2] = moved(initial[2], {0.01, 0, 0});
  const ExtrinsicResult result = estimate(scene, initial);
  EXPECT_LT(apart(result.T_world_camera[1], cameras[1].T_world_camera), 0.0005) << "the others are put right";
  EXPECT_EQ(result.corrections[2].translation, 0.0);
  EXPECT_EQ(result.corrections[2].neighbours, 0u);
  EXPECT_FALSE(result.corrections[2].constrained);
  EXPECT_EQ(result.corrections[2].free_directions.size(), 6u);
}

TEST(ExtrinsicEstimation, AnEmptyRoomIsEnough) {
  const std::vector<Camera> cameras = cornerCameras(3);
  const Scene scene =
      makeScene(cameras, nearest({plane({0, -1, 0}, -0.5), plane({-0.8, 0, -0.6}, -1.5), plane({0.6, 0, -0.8}, -1.6)}));
  const ExtrinsicResult result = estimate(scene, disturbed(cameras));
  for (std::size_t i = 0; i < cameras.size(); ++i)
    EXPECT_LT(apart(result.T_world_camera[i], cameras[i].T_world_camera), 0.0005) << i;
}

TEST(ExtrinsicEstimation, AMissingViewIsLeftOut) {
  const std::vector<Camera> cameras = cornerCameras(4);
  Scene scene = makeScene(cameras, cornerAndBall());
  scene.rig.views[3] = DepthView();
  const ExtrinsicResult result = estimate(scene, disturbed(cameras));
  EXPECT_LT(apart(result.T_world_camera[1], cameras[1].T_world_camera), 0.0005);
  EXPECT_EQ(result.corrections[3].translation, 0.0);
}

TEST(ExtrinsicEstimation, WhereTheWorldsOriginLiesDoesNotMatter) {
  const std::vector<Camera> cameras = cornerCameras(3);
  const Scene scene = makeScene(cameras, cornerAndBall());
  const std::vector<Eigen::Isometry3d> initial = disturbed(cameras);
  Eigen::Isometry3d G = Eigen::Isometry3d::Identity();
  G.pretranslate(Vector3d(800, -300, 40));
  G.rotate(Eigen::AngleAxisd(2.1, Vector3d(1, -2, 0.5).normalized()));
  std::vector<Eigen::Isometry3d> elsewhere;
  for (const Eigen::Isometry3d& T : initial) elsewhere.push_back(G * T);
  const ExtrinsicResult here = estimate(scene, initial), there = estimate(scene, elsewhere);
  for (std::size_t i = 0; i < cameras.size(); ++i)
    EXPECT_LT(apart(G * here.T_world_camera[i], there.T_world_camera[i]), 0.0003) << i;
}

TEST(ExtrinsicEstimation, TheNumberOfThreadsDoesNotMatter) {
  const std::vector<Camera> cameras = cornerCameras(3);
  Scene scene = makeScene(cameras, cornerAndBall());
  addNoise(scene, 0.003f);
  const ExtrinsicResult one = estimate(scene, disturbed(cameras), {}, 1),
                        five = estimate(scene, disturbed(cameras), {}, 5);
  for (std::size_t i = 0; i < cameras.size(); ++i)
    EXPECT_EQ(one.T_world_camera[i].matrix(), five.T_world_camera[i].matrix()) << i;
}

TEST(ExtrinsicEstimation, SeveralInstantsAverageNoiseAway) {
  const std::vector<Camera> cameras = cornerCameras(3);
  double one = 0, eight = 0;
  Estimation estimation;
  for (unsigned int k = 0; k < 8; ++k) {
    Scene scene = makeScene(cameras, cornerAndBall());
    addNoise(scene, 0.02f, 100 + k);
    estimation.addFrame(scene.rig);
    one += apart(estimate(scene, poses(cameras)).T_world_camera[2], cameras[2].T_world_camera) / 8;
  }
  eight = apart(estimation.estimate().T_world_camera[2], cameras[2].T_world_camera);
  EXPECT_LT(eight, 0.6 * one);
}

TEST(ExtrinsicEstimation, CloudsInTheCamerasFramesAreTheSameAsDepthImages) {
  const std::vector<Camera> cameras = cornerCameras(2);
  const Scene scene = makeScene(cameras, cornerAndBall());
  std::vector<Camera> wrong = cameras;
  wrong[1].T_world_camera = moved(cameras[1].T_world_camera, {0.01, 0, 0.01});
  std::vector<pcl::PointCloud<pcl::PointXYZ>::ConstPtr> clouds;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const auto cloud = std::make_shared<pcl::PointCloud<pcl::PointXYZ>>(160, 120);
    for (std::size_t k = 0; k < cloud->size(); ++k) (*cloud)[k] = {0, 0, scene.depth[i].data[k]};
    clouds.push_back(cloud);
  }
  Estimation estimation;
  estimation.addClouds(wrong, clouds);
  EXPECT_EQ(estimation.estimate().T_world_camera[1].matrix(), estimate(scene, poses(wrong)).T_world_camera[1].matrix());
}

TEST(ExtrinsicEstimation, OneCameraAloneStays) {
  const std::vector<Camera> cameras = cornerCameras(1);
  const ExtrinsicResult result = estimate(makeScene(cameras, cornerAndBall()), poses(cameras));
  EXPECT_EQ(result.T_world_camera[0].matrix(), cameras[0].T_world_camera.matrix());
}

TEST(ExtrinsicEstimation, WrongInputIsRefused) {
  const std::vector<Camera> cameras = cornerCameras(2);
  const Scene scene = makeScene(cameras, cornerAndBall());
  Estimation estimation;
  EXPECT_THROW(estimation.estimate(), pcl::PCLException) << "no frame";
  estimation.addFrame(scene.rig);
  EXPECT_THROW(estimation.estimate({Eigen::Isometry3d::Identity()}), pcl::BadArgumentException) << "one pose for two";
  std::vector<Eigen::Isometry3d> stretched = poses(cameras);
  stretched[1].linear() *= 1.1;
  EXPECT_THROW(estimation.estimate(stretched), pcl::BadArgumentException);
  EXPECT_THROW(estimation.addFrame(makeScene(cornerCameras(3), cornerAndBall()).rig), pcl::BadArgumentException);
  RigFrame other_lens = scene.rig;
  other_lens.cameras[1].intrinsics.fx *= 1.1f;
  refusal::expectThrow([&] { estimation.addFrame(other_lens); }, {"ExtrinsicEstimation", "intrinsics"});
  EXPECT_THROW(estimation.addClouds(cameras, {}), pcl::BadArgumentException);
  for (const auto set : std::vector<void (*)(ExtrinsicParameters&)>{
           [](ExtrinsicParameters& p) { p.reduction = 0; }, [](ExtrinsicParameters& p) { p.samples = 10; },
           [](ExtrinsicParameters& p) { p.coarse_above = -1; }, [](ExtrinsicParameters& p) { p.max_speckle = -1; },
           [](ExtrinsicParameters& p) { p.max_speckle = std::nanf(""); },
           [](ExtrinsicParameters& p) { p.max_neighbours = 0; },
           [](ExtrinsicParameters& p) { p.max_correspondence_distance = 0; },
           [](ExtrinsicParameters& p) { p.min_correspondence_distance = 1; },
           [](ExtrinsicParameters& p) { p.max_normal_angle = 2; },
           [](ExtrinsicParameters& p) { p.residual_multipath = -1; },
           [](ExtrinsicParameters& p) { p.residual_multipath = std::nanf(""); },
           [](ExtrinsicParameters& p) { p.min_information = 0; }, [](ExtrinsicParameters& p) { p.max_iterations = 0; },
           [](ExtrinsicParameters& p) { p.max_correspondence_distance = std::nanf(""); }}) {
    ExtrinsicParameters parameters;
    set(parameters);
    EXPECT_THROW(estimation.setParameters(parameters), pcl::BadArgumentException);
  }
}

}  // namespace
