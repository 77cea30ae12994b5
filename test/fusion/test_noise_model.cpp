// Cameras whose depth is as noisy as their own model says; and measures of confidence that are the user's.

#include "../refusal.h"
#include "../scenes.h"

#include <fuse_flow/calibration/extrinsic_estimation.h>
#include <fuse_flow/filters/multi_view_consistency.h>

#include <cmath>
#include <optional>

namespace {

using fuse_flow::ConfidenceForm;
using fuse_flow::ConfidenceParameters;
using fuse_flow::FrameStatistics;
using fuse_flow::FuseFlowParameters;
using fuse_flow::NoiseModel;
using fuse_flow::ViewNoise;
using scenes::Cloud;
using scenes::Scene;

constexpr NoiseModel kDefault{};
constexpr NoiseModel kTwice{2 * kDefault.floor, 2 * kDefault.linear, 2 * kDefault.quadratic};

TEST(NoiseModel, IsAPolynomialOfDepth) {
  const NoiseModel model{0.001f, 0.002f, 0.003f};
  EXPECT_FLOAT_EQ(axialNoise(model, 2), 0.001f + 0.004f + 0.012f);
  EXPECT_FLOAT_EQ(inverseDepthNoise(model, 0.5f), (0.001f + 0.004f + 0.012f) / 4);
}

TEST(NoiseModel, OfStereoIsTheDisparitysOverFocalLengthAndBaseline) {
  // A match that is off by 0.1 pixels: f b = 20 pixels · metres, z² σ_d / (f b) = 4 · 0.1 / 20.
  EXPECT_FLOAT_EQ(axialNoise(NoiseModel::stereo(400, 0.05f, 0.1f, 0), 2), 0.02f);
  EXPECT_FLOAT_EQ(axialNoise(NoiseModel::stereo(400, 0.05f, 0.1f, 0.003f), 2), 0.023f);
}

/** \brief One measurement each of two cameras at the same place, fused by what they weigh alone. */
FuseFlowParameters weightsAlone() {
  FuseFlowParameters p;
  p.use_distance_consistency = p.adapt_noise = false;
  p.smoothing.passes = p.min_support = 0;
  p.max_noise = p.confidence.threshold = 0;
  p.half_weight_noise = 0.01f;
  p.aggregation.points_per_cell = 100;
  p.aggregation.min_weight = p.aggregation.weak_weight = 0;
  return p;
}

TEST(CameraNoise, TheNoisierSensorWeighsLess) {
  Scene scene = scenes::makeFlatScene(scenes::sameCameras(2, 1, 1, 40), {1.0f, 1.004f});
  scene.rig.cameras[0].noise = NoiseModel{0.004f, 0.002f, 0.004f};           // 10 mm at 1 m: a half
  scene.rig.cameras[1].noise = NoiseModel{0, 0, 0.03f / (1.004f * 1.004f)};  // 30 mm: a tenth
  const Cloud cloud = scenes::fuse(scene.rig, weightsAlone());
  ASSERT_EQ(cloud.size(), 1u);
  EXPECT_NEAR(cloud[0].z, (0.5 * 1.0 + 0.1 * 1.004) / 0.6, 1e-6);
}

TEST(CameraNoise, TooMuchOfItDropsThatCameraAlone) {
  Scene scene = scenes::makeFlatScene(scenes::sameCameras(2, 1, 1, 40), {1.0f, 1.004f});
  scene.rig.cameras[1].noise = NoiseModel{0.03f, 0, 0};
  FuseFlowParameters p = weightsAlone();
  p.max_noise = 0.02f;
  FrameStatistics statistics;
  const Cloud cloud = scenes::fuse(scene.rig, p, 1, &statistics);
  EXPECT_EQ(statistics.measured_points, 2u);
  EXPECT_EQ(statistics.gated_points, 1u);
  ASSERT_EQ(cloud.size(), 1u);
  EXPECT_FLOAT_EQ(cloud[0].z, 1.0f);
}

Scene noisyRow() {
  Scene scene = scenes::makeScene(
      scenes::cameraRow(4), scenes::nearest({scenes::plane({0, 0, 1}, 1.6), scenes::sphere({0.05, 0, 1.3}, 0.2)}));
  scenes::addNoise(scene, 0.004f);
  return scene;
}

void expectSameBytes(const Cloud& a, const Cloud& b) {
  ASSERT_EQ(a.size(), b.size());
  ASSERT_GT(a.size(), 500u);
  for (std::size_t k = 0; k < a.size(); ++k) {
    ASSERT_EQ(a[k].getVector3fMap(), b[k].getVector3fMap());
    ASSERT_EQ(a[k].confidence, b[k].confidence);
    ASSERT_EQ(a[k].view_count, b[k].view_count);
  }
}

TEST(CameraNoise, TheParametersModelIsThatOfCamerasWithoutOne) {
  Scene scene = noisyRow();
  const Cloud without = scenes::fuse(scene.rig, {});
  for (fuse_flow::Camera& camera : scene.rig.cameras) camera.noise = kDefault;
  expectSameBytes(scenes::fuse(scene.rig, {}), without);
}

// Doubling is exact in floating point: everything that asks for noise must come to the same bytes.
TEST(CameraNoise, TwiceTheModelIsHalfTheMeasuredScaleAndTheSameCloud) {
  Scene scene = noisyRow();
  for (const float wide_above : {0.1f, 0.75f, 1e6f}) {  // the second between the scale with and without the model
    FuseFlowParameters p;
    p.smoothing.wide_above = wide_above;
    FrameStatistics before, after;
    for (fuse_flow::Camera& camera : scene.rig.cameras) camera.noise.reset();
    const Cloud cloud = scenes::fuse(scene.rig, p, 1, &before);
    for (const std::size_t i : {1u, 3u}) scene.rig.cameras[i].noise = kTwice;  // and two as they were
    expectSameBytes(scenes::fuse(scene.rig, p, 1, &after), cloud);
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_GT(before.noise_scales[i], 0.8f) << "far from its bounds";
      EXPECT_LT(before.noise_scales[i], 1.4f);
      EXPECT_EQ(after.noise_scales[i], (i % 2 == 1 ? 0.5f : 1.0f) * before.noise_scales[i]);
    }
  }
}

TEST(CameraNoise, TwiceTheModelIsHalfTheMeasuredScaleAndTheSamePoses) {
  std::vector<fuse_flow::Camera> cameras = scenes::cameraRow(3, 240, 180, 220);
  Scene scene = scenes::makeScene(
      cameras, scenes::nearest({scenes::plane({0, 0, 1}, 1.6), scenes::plane({0.3, 1, 0}, 0.5),
                                scenes::plane({1, 0.2, 0.1}, 0.9), scenes::sphere({0.05, 0, 1.2}, 0.2)}));
  scenes::addNoise(scene, 0.004f);
  scene.rig.cameras[1].T_world_camera.translate(Eigen::Vector3d(0.01, -0.005, 0.008));
  const auto estimate = [&] {
    fuse_flow::ExtrinsicEstimation<fuse_flow::PointFused> estimation;
    estimation.addFrame(scene.rig);
    return estimation.estimate();
  };
  const fuse_flow::ExtrinsicResult before = estimate();
  scene.rig.cameras[0].noise = scene.rig.cameras[2].noise = kTwice;
  const fuse_flow::ExtrinsicResult after = estimate();
  ASSERT_GT(before.iterations, 2);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_EQ(after.T_world_camera[i].matrix(), before.T_world_camera[i].matrix()) << i;
}

// A point 30 mm behind what one camera measures: 1.5 σ of 20 mm, and one of the camera's own 30.
TEST(CameraNoise, WidensSigmaInTheFiltersToo) {
  Scene scene = scenes::makeFlatScene(scenes::sameCameras(1, 3, 3, 40), {1.0f});
  const auto cloud = std::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  cloud->emplace_back(0.0f, 0.0f, 1.03f);
  const auto V = [&] {
    fuse_flow::MultiViewConsistency<pcl::PointXYZ> filter;
    filter.setFrame(scene.rig);
    filter.setInputCloud(cloud);
    pcl::PointCloud<pcl::PointXYZ> kept;
    filter.filter(kept);
    return filter.getConsistency().at(0);
  };
  EXPECT_NEAR(V(), std::exp(-2.25), 1e-4);
  scene.rig.cameras[0].noise = NoiseModel{0.03f, 0, 0};
  EXPECT_NEAR(V(), std::exp(-1.0), 1e-4);
}

TEST(CameraNoise, WhatIsNoModelIsNamed) {
  Scene scene = scenes::makeFlatScene(scenes::sameCameras(1, 2, 2, 40), {1.0f});
  scene.rig.cameras[0].name = "left";
  for (const auto& [noise, message] : {std::pair{NoiseModel{-0.1f, 0, 0}, "noise.floor is -0.1"},
                                       {NoiseModel{0, 11, 0}, "noise.linear is 11"},
                                       {NoiseModel{0, 0, NAN}, "noise.quadratic is nan"},
                                       {NoiseModel{0, 0, 0}, "noise is 0 at every depth"}}) {
    scene.rig.cameras[0].noise = noise;
    refusal::expectThrow([&] { scenes::fuse(scene.rig, {}); }, {"Camera 'left'", message});
  }
}

// ---- The gate of eq. 9 is for what is noisy

/** \brief How many measurements of a ball, whose rim is steep, become points. \param depth of its centre  \param gate_noise m */
std::size_t pointsOfBall(double depth, float gate_noise, std::size_t* measured = nullptr,
                         std::optional<NoiseModel> noise = std::nullopt) {
  const double radius = 0.1 * depth;  // the same image at any depth
  Scene scene = scenes::makeScene(scenes::sameCameras(1, 96, 72, 400), scenes::sphere({0, 0, depth}, radius));
  scene.rig.cameras[0].noise = noise;
  FuseFlowParameters p;
  p.use_spatial_hash = false;  // a point a measurement
  p.smoothing.passes = 0;
  p.adapt_noise = false;
  p.min_support = 0;
  p.gate_noise = gate_noise;
  FrameStatistics statistics;
  scenes::fuse(scene.rig, p, 1, &statistics);
  if (measured != nullptr) *measured = statistics.measured_points;
  return statistics.gated_points;
}

TEST(GateNoise, KeepsTheRimsOfWhatIsMeasuredExactly) {
  std::size_t measured = 0;
  const std::size_t asked = pointsOfBall(2, 0, &measured);  // from 1.8 to 2 m: σ is 5.1 to 6.2 mm
  EXPECT_LT(asked, measured) << "else there is nothing to keep";
  EXPECT_EQ(pointsOfBall(2, 0.005f), asked);
  EXPECT_EQ(pointsOfBall(2, 0.0065f), measured);
  EXPECT_EQ(pointsOfBall(2, FuseFlowParameters().gate_noise), measured);
}

TEST(GateNoise, DoesNotKeepThoseOfWhatIsNoisy) {
  std::size_t measured = 0;
  const std::size_t asked = pointsOfBall(4.4, 0, &measured);  // σ(4 m) is 23 mm: more than the default
  ASSERT_LT(asked, measured);
  EXPECT_EQ(pointsOfBall(4.4, FuseFlowParameters().gate_noise), asked);
}

TEST(GateNoise, IsAboutTheNoiseThatTheCameraHas) {
  std::size_t measured = 0;
  const std::size_t asked = pointsOfBall(2, 0, &measured);
  EXPECT_EQ(pointsOfBall(2, 0.02f, nullptr, NoiseModel{0.019f, 0, 0}), measured);
  EXPECT_LT(pointsOfBall(2, 0.02f, nullptr, NoiseModel{0.021f, 0, 0}), measured);
  EXPECT_EQ(pointsOfBall(4.4, 0.02f, nullptr, NoiseModel{0.019f, 0, 0}), measured) << "exact far away, too";
  EXPECT_LT(asked, measured);
}

TEST(GateNoise, IsForViewsThatDoNotSayHowSureTheyAre) {
  const Scene wall = scenes::makeFlatScene(scenes::sameCameras(1, 41, 31, 40), {1.0f});
  Scene sure = scenes::makeFlatScene(scenes::sameCameras(1, 41, 31, 40), {1.0f});
  sure.confidence.push_back(scenes::uniform(41, 31, 1.0f));
  sure.attach();
  FrameStatistics statistics;
  scenes::fuse(wall.rig, {}, 1, &statistics);
  EXPECT_EQ(statistics.gated_points, 41u * 31u);
  scenes::fuse(sure.rig, {}, 1, &statistics);
  EXPECT_EQ(statistics.gated_points, 41u * 31u - 4u) << "C of a corner of the image is below tau";
}

TEST(GateNoise, IsNotInThePublishedFormNorForEstimatedDepthNorForGivenConfidence) {
  EXPECT_EQ(FuseFlowParameters::published().gate_noise, 0.0f);
  EXPECT_EQ(FuseFlowParameters::estimatedDepth().gate_noise, 0.0f);
  Scene scene = scenes::makeFlatScene(scenes::sameCameras(1, 9, 9, 40), {1.0f});
  scene.confidence.push_back(scenes::uniform(9, 9, 0.55f));
  scene.attach();
  FuseFlowParameters p;
  p.confidence.form = ConfidenceForm::Given;
  FrameStatistics statistics;
  scenes::fuse(scene.rig, p, 1, &statistics);
  EXPECT_EQ(statistics.gated_points, 0u) << "0.55 is under tau, and the user's word counts";
}

// ---- The user's own measure of confidence

TEST(GivenConfidence, IsWhatTheGateLooksAtAndWhatPointsWeigh) {
  Scene scene = scenes::makeFlatScene(scenes::sameCameras(1, 40, 30, 40), {1.0f});
  scene.confidence.push_back(scenes::uniform(40, 30, 0.7f));
  for (int v = 0; v < 30; ++v)
    for (int u = 0; u < 20; ++u) scene.confidence[0].at(u, v) = v < 15 ? 0.6f : std::nanf("");
  scene.attach();
  FuseFlowParameters p = weightsAlone();
  p.half_weight_noise = 0;
  p.use_spatial_hash = false;  // a point a pixel
  p.confidence.form = ConfidenceForm::Given;
  p.confidence.threshold = 0.65f;
  const Cloud cloud = scenes::fuse(scene.rig, p);
  EXPECT_EQ(cloud.size(), 20u * 30);
  for (const auto& point : cloud) ASSERT_EQ(point.confidence, 0.7f);
  p.confidence.threshold = 0.5f;
  EXPECT_EQ(scenes::fuse(scene.rig, p).size(), 20u * 30 + 20u * 15);
  p.min_confidence = 0.65f;
  EXPECT_EQ(scenes::fuse(scene.rig, p).size(), 20u * 30);
  p.min_support = 3;
  p.min_confidence = 0;
  EXPECT_EQ(scenes::fuse(scene.rig, p).size(), 20u * 30 + 20u * 15) << "corners have three neighbours";
}

TEST(GivenConfidence, IsAskedOfEveryViewThatIsThere) {
  Scene scene = scenes::makeFlatScene(scenes::sameCameras(2, 4, 4, 40), {1.0f, 1.0f});
  scene.rig.cameras[1].name = "right";
  scene.confidence.push_back(scenes::uniform(4, 4, 1.0f));
  scene.attach();
  FuseFlowParameters p;
  p.confidence.form = ConfidenceForm::Given;
  refusal::expectThrow([&] { scenes::fuse(scene.rig, p); }, {"camera 'right'", "gives no confidence", "Given"});
  scene.rig.views[1] = {};  // a missing one need not
  EXPECT_NO_THROW(scenes::fuse(scene.rig, p));
}

}  // namespace
