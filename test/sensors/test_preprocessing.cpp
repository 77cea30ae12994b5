#include "../scenes.h"

#include <fuse_flow/filters/depth_backprojection.h>
#include <fuse_flow/math/depth.h>

// The optional steps between the raw depth and D^r: small holes filled, and the bilateral filter.

namespace {

using fuse_flow::PreprocessingParameters;
using fuse_flow::io::FloatImage;
using scenes::Scene;

PreprocessingParameters fillingFrom(int neighbours) {
  PreprocessingParameters p;
  p.fill_neighbours = neighbours;
  return p;
}

/** \brief With standard deviations of 3 pixels and 30 mm. */
PreprocessingParameters bilateral() {
  PreprocessingParameters p;
  p.bilateral = true;
  return p;
}

/** \brief D^r of a camera that stands at the origin; NaN where there is none. */
FloatImage preprocessed(const Scene& scene, const PreprocessingParameters& parameters) {
  fuse_flow::DepthBackprojection<pcl::PointXYZ> filter;
  filter.setCamera(scene.rig.cameras[0]);
  filter.setView(scene.rig.views[0]);
  filter.setParameters(parameters);
  pcl::PointCloud<pcl::PointXYZ> cloud;
  filter.filter(cloud);
  FloatImage depth = scene.depth[0];
  for (std::size_t k = 0; k < cloud.size(); ++k) depth.data[k] = cloud[k].z;
  return depth;
}

Scene inFrontOf(const scenes::Surface& surface) {
  return scenes::makeScene(scenes::sameCameras(1, 120, 90, 150), surface);
}

scenes::Surface inclinedWall() { return scenes::plane(scenes::Vector3d(0.2, -0.1, 1).normalized(), 1.5); }

/** \brief The left half at 1.2 m, the right half at 1.4 m: columns 0 … 59 and 60 … 119. */
scenes::Surface step() { return scenes::nearest({scenes::square(-1, 0, 1.2, 1), scenes::plane({0, 0, 1}, 1.4)}); }

// ---- Small holes

TEST(SmallHoles, OneInAPlaneGetsThePlanesDepth) {
  Scene scene = inFrontOf(inclinedWall());
  const FloatImage exact = scene.depth[0];
  scene.depth[0].at(40, 30) = 0;  // its neighbours are up to 3 mm nearer or farther
  const FloatImage filled = preprocessed(scene, fillingFrom(8));
  for (std::size_t k = 0; k < exact.data.size(); ++k) ASSERT_NEAR(filled.data[k], exact.data[k], 2e-5f) << k;
  EXPECT_TRUE(std::isnan(preprocessed(scene, {}).at(40, 30)));
}

TEST(SmallHoles, OneAtAStepIsNotBridged) {
  Scene scene = inFrontOf(step());
  ASSERT_EQ(scene.depth[0].at(59, 30), 1.2f);
  ASSERT_EQ(scene.depth[0].at(60, 30), 1.4f);
  for (const int u : {20, 59, 60, 100}) scene.depth[0].at(u, 30) = 0;
  const FloatImage filled = preprocessed(scene, fillingFrom(5));
  EXPECT_TRUE(std::isnan(filled.at(59, 30)));
  EXPECT_TRUE(std::isnan(filled.at(60, 30)));
  EXPECT_NEAR(filled.at(20, 30), 1.2f, 1e-6f);
  EXPECT_NEAR(filled.at(100, 30), 1.4f, 1e-6f);
}

TEST(SmallHoles, OfThreeByThreePixelsOnlyTheCornersHaveFiveMeasuredNeighbours) {
  Scene scene = inFrontOf(inclinedWall());
  const FloatImage exact = scene.depth[0];
  for (int v = 29; v <= 31; ++v)
    for (int u = 39; u <= 41; ++u) scene.depth[0].at(u, v) = 0;
  const FloatImage four = preprocessed(scene, fillingFrom(4)), six = preprocessed(scene, fillingFrom(6));
  for (int v = 29; v <= 31; ++v)
    for (int u = 39; u <= 41; ++u) {
      // A corner has five measured neighbours, another pixel of the rim three: what was filled does not count.
      if (u != 40 && v != 30) {
        EXPECT_NEAR(four.at(u, v), exact.at(u, v), 0.005f);
      } else {
        EXPECT_TRUE(std::isnan(four.at(u, v))) << u << ", " << v;
      }
      EXPECT_TRUE(std::isnan(six.at(u, v))) << u << ", " << v;
    }
}

TEST(SmallHoles, NeighboursMayDifferByTheToleranceTimesTheSquaredDepthBeyondOneMetre) {
  const PreprocessingParameters p = fillingFrom(3);  // 20 mm
  const auto filled = [&](float a, float b, float c) { return fuse_flow::filledDepth(p, {a, 0, 0, 0, 0, b, 0, c, 0}); };
  EXPECT_FLOAT_EQ(filled(0.490f, 0.500f, 0.509f), 0.4996667f);
  EXPECT_EQ(filled(0.490f, 0.500f, 0.511f), 0.0f);
  EXPECT_FLOAT_EQ(filled(1.961f, 2.000f, 2.039f), 2.0f);  // 80 mm at 2 m
  EXPECT_EQ(filled(1.959f, 2.000f, 2.041f), 0.0f);
  EXPECT_EQ(filled(0.500f, 0.500f, 0), 0.0f);  // two neighbours
}

// ---- The bilateral filter

/** \brief Root mean square of what differs, and its mean, over columns begin … end − 1. */
std::array<double, 2> differenceOf(const FloatImage& depth, const FloatImage& exact, int begin, int end) {
  double sum = 0, squares = 0, n = 0;
  for (int v = 0; v < depth.height; ++v)
    for (int u = begin; u < end; ++u) {
      const auto e = static_cast<double>(depth.at(u, v)) - static_cast<double>(exact.at(u, v));
      sum += e;
      squares += e * e;
      ++n;
    }
  return {std::sqrt(squares / n), sum / n};
}

TEST(Bilateral, TakesMostOfTheNoiseOffAWallAndDoesNotMoveIt) {
  Scene scene = inFrontOf(scenes::plane({0, 0, 1}, 1.5));
  const FloatImage exact = scene.depth[0];
  scenes::addNoise(scene, 0.005f);
  const auto before = differenceOf(scene.depth[0], exact, 0, 120);
  const auto after = differenceOf(preprocessed(scene, bilateral()), exact, 0, 120);
  EXPECT_NEAR(before[0], 0.005, 0.0002);
  // A Gaussian of 3 pixels averages 4 π 3² of them: a tenth of the noise.
  EXPECT_LT(after[0], 0.25 * before[0]);
  EXPECT_LT(std::abs(after[1] - before[1]), 0.02 * before[0]);
}

TEST(Bilateral, LeavesAStepWhereItIsAndSmoothesBothSidesOfIt) {
  Scene scene = inFrontOf(step());
  const FloatImage exact = scene.depth[0];
  scenes::addNoise(scene, 0.003f);
  const FloatImage smooth = preprocessed(scene, bilateral());
  for (std::size_t k = 0; k < exact.data.size(); ++k) ASSERT_NEAR(smooth.data[k], exact.data[k], 0.006f) << k;
  for (const auto& [begin, end] : {std::array{0, 60}, {60, 120}, {57, 60}, {60, 63}})
    EXPECT_LT(differenceOf(smooth, exact, begin, end)[0], 0.5 * differenceOf(scene.depth[0], exact, begin, end)[0]);
}

TEST(Bilateral, ADepthDeviationAboveTheStepBlursItAndASmallOneKeepsTheNoise) {
  Scene scene = inFrontOf(step());
  const FloatImage exact = scene.depth[0];
  scenes::addNoise(scene, 0.003f);
  PreprocessingParameters p = bilateral();
  p.bilateral_sigma_r = 2;
  const FloatImage blurred = preprocessed(scene, p);
  EXPECT_GT(differenceOf(blurred, exact, 59, 60)[1], 0.03);
  EXPECT_LT(differenceOf(blurred, exact, 60, 61)[1], -0.03);
  p.bilateral_sigma_r = 0.0005f;
  EXPECT_GT(differenceOf(preprocessed(scene, p), exact, 0, 120)[0], 0.0015);
}

TEST(Bilateral, HolesStayHolesAndNothingElseBecomesOne) {
  Scene scene = inFrontOf(step());
  for (std::size_t k = 0; k < scene.depth[0].data.size(); k += 7) scene.depth[0].data[k] = 0;
  const FloatImage smooth = preprocessed(scene, bilateral());
  for (std::size_t k = 0; k < smooth.data.size(); ++k) ASSERT_EQ(std::isnan(smooth.data[k]), k % 7 == 0) << k;
}

TEST(Preprocessing, IsTheSameInTheFramePipeline) {
  Scene scene = inFrontOf(step());
  scenes::addNoise(scene, 0.003f);
  for (const std::size_t k : {500u, 501u, 700u, 3010u, 4000u, 4001u, 4121u, 9010u}) scene.depth[0].data[k] = 0;
  fuse_flow::FuseFlowParameters parameters;
  parameters.use_spatial_hash = parameters.use_measurement_confidence = false;  // a point a pixel
  parameters.smoothing.passes = 0;
  parameters.preprocessing = bilateral();
  parameters.preprocessing.fill_neighbours = 7;
  const FloatImage expected = preprocessed(scene, parameters.preprocessing);
  const scenes::Cloud cloud = scenes::fuse(scene.rig, parameters);
  std::size_t next = 0;
  for (const float z : expected.data) {
    if (std::isnan(z)) continue;
    ASSERT_LT(next, cloud.size());
    ASSERT_EQ(cloud[next].z, z);
    ++next;
  }
  EXPECT_EQ(next, cloud.size());
  EXPECT_EQ(next, expected.data.size() - 3);  // those of 4000, 4001 and 4121 touch
}

}  // namespace
