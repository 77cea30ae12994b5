#include "../refusal.h"
#include "../scenes.h"

#include <fuse_flow/quality/reprojection_quality.h>

// The measures themselves, by hand. test_quality.cpp asks them what fusion is worth.

namespace {

using fuse_flow::reprojectionQuality;
using fuse_flow::ReprojectionQuality;
using fuse_flow::ReprojectionQualityParameters;
using scenes::Scene;
using Points = pcl::PointCloud<pcl::PointXYZ>;

/** \brief Two cameras of one pose on a wall that they put 2 cm apart. */
Scene disagreeingCameras() { return scenes::makeFlatScene(scenes::sameCameras(2, 20, 15, 40), {1.0f, 1.02f}); }

/** \brief One point on the ray of every pixel, at depth z. */
Points onEveryRay(float z, int width = 20, int height = 15, float focal = 40) {
  Points cloud;
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u)
      cloud.push_back({(static_cast<float>(u) - 0.5f * static_cast<float>(width - 1)) / focal * z,
                       (static_cast<float>(v) - 0.5f * static_cast<float>(height - 1)) / focal * z, z});
  return cloud;
}

TEST(QualityMeasure, TheMiddleBetweenTwoCamerasIsOffByHalfTheirDisagreement) {
  const Scene scene = disagreeingCameras();
  const ReprojectionQuality quality = reprojectionQuality(onEveryRay(1.01f), scene.rig);
  EXPECT_NEAR(quality.error, 0.01, 1e-6);
  EXPECT_NEAR(quality.multi_view_error, 0.01, 1e-6);
  EXPECT_EQ(quality.points, 300u);
  EXPECT_EQ(quality.seen_points, 300u);
  EXPECT_EQ(quality.multi_view_points, 300u);
  EXPECT_EQ(quality.violating_points, 0u);
}

TEST(QualityMeasure, EachPointCountsOnceHoweverManyCamerasSeeIt) {
  // Where the second camera has no measurement only the first judges.
  Scene scene = disagreeingCameras();
  for (int u = 0; u < 20; ++u)
    for (int v = 0; v < 15; ++v)
      if (u >= 5) scene.depth[1].at(u, v) = 0;
  const ReprojectionQuality quality = reprojectionQuality(onEveryRay(1.0f), scene.rig);
  EXPECT_EQ(quality.seen_points, 300u);
  EXPECT_EQ(quality.multi_view_points, 75u);
  EXPECT_NEAR(quality.multi_view_error, 0.01, 1e-6);           // (0 + 2 cm) / 2
  EXPECT_NEAR(quality.error, 0.25 * 0.01 + 0.75 * 0.0, 1e-6);  // the mean over points, not over measurements
}

TEST(QualityMeasure, APointInFreeSpaceViolatesAndOneBehindTheWallDoesNot) {
  const Scene scene = disagreeingCameras();
  Points cloud;
  cloud.push_back({0, 0, 0.5f});   // floats
  cloud.push_back({0, 0, 0.96f});  // 4 cm before the first: seen by it; 6 cm before the second: violates
  cloud.push_back({0, 0, 1.5f});   // hidden
  cloud.push_back({0, 0, -1.0f});  // behind the cameras
  cloud.push_back({9, 0, 1.0f});   // outside the images
  cloud.push_back({std::numeric_limits<float>::quiet_NaN(), 0, 1});
  const ReprojectionQuality quality = reprojectionQuality(cloud, scene.rig);
  EXPECT_EQ(quality.points, 6u);
  EXPECT_EQ(quality.violating_points, 2u);
  EXPECT_EQ(quality.seen_points, 1u);
  EXPECT_EQ(quality.multi_view_points, 0u);
  EXPECT_NEAR(quality.error, 0.04, 1e-6);
  EXPECT_TRUE(std::isnan(quality.multi_view_error));
  EXPECT_DOUBLE_EQ(quality.violationShare(), 2.0 / 6.0);
}

TEST(QualityMeasure, ACloudThatNobodySeesHasNoError) {
  const Scene scene = disagreeingCameras();
  Points hidden;
  hidden.push_back({0, 0, 3.0f});
  for (const Points& cloud : {Points(), hidden}) {
    const ReprojectionQuality quality = reprojectionQuality(cloud, scene.rig);
    EXPECT_TRUE(std::isnan(quality.error));
    EXPECT_TRUE(std::isnan(quality.multi_view_error));
    EXPECT_EQ(quality.pixels, 600u);
    EXPECT_EQ(quality.coverage(), 0.0);
    EXPECT_EQ(quality.violationShare(), 0.0);
  }
}

TEST(QualityMeasure, AllMeasurementsCoverThemselvesAndHalfOfThemHalf) {
  const Scene scene = scenes::makeFlatScene(scenes::sameCameras(1, 20, 15, 40), {1.0f});  // pixels 25 mm apart
  const Points all = onEveryRay(1.0f);
  EXPECT_EQ(reprojectionQuality(all, scene.rig).coverage(), 1.0);
  Points half;
  for (const auto& point : all)
    if (point.x > 0) half.push_back(point);
  EXPECT_EQ(reprojectionQuality(half, scene.rig).covered_pixels, 150u);
  ReprojectionQualityParameters wide;
  wide.coverage_radius = 0.026f;  // reaches one column more
  EXPECT_EQ(reprojectionQuality(half, scene.rig, wide).covered_pixels, 165u);
  ReprojectionQualityParameters sparse;
  sparse.coverage_step = 4;  // columns 0, 4 … 16, rows 0, 4, 8, 12
  EXPECT_EQ(reprojectionQuality(all, scene.rig, sparse).pixels, 20u);
}

TEST(QualityMeasure, OnlyMeasurementsInRangeCount) {
  const Scene scene = disagreeingCameras();
  ReprojectionQualityParameters parameters;
  parameters.max_range = 1.01f;  // the second camera's are beyond
  const ReprojectionQuality quality = reprojectionQuality(onEveryRay(1.0f), scene.rig, parameters);
  EXPECT_EQ(quality.pixels, 300u);
  EXPECT_EQ(quality.multi_view_points, 0u);
  EXPECT_NEAR(quality.error, 0.0, 1e-6);
}

TEST(QualityMeasure, ParametersOutOfRangeAreRefusedByName) {
  constexpr float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
  const Scene scene = disagreeingCameras();
  const auto refused = [&](float ReprojectionQualityParameters::*member, float value, const char* message) {
    ReprojectionQualityParameters parameters;
    parameters.*member = value;
    refusal::expectThrow([&] { reprojectionQuality(onEveryRay(1.0f), scene.rig, parameters); },
                         {"reprojectionQuality", message});
  };
  refused(&ReprojectionQualityParameters::visibility, -1, "visibility is -1");
  refused(&ReprojectionQualityParameters::visibility, inf, "visibility is inf");
  refused(&ReprojectionQualityParameters::coverage_radius, 0, "coverage_radius is 0");
  refused(&ReprojectionQualityParameters::coverage_radius, nan, "coverage_radius is nan");
  refused(&ReprojectionQualityParameters::min_range, -0.5f, "min_range is -0.5");
  refused(&ReprojectionQualityParameters::max_range, inf, "max_range is inf");
  refused(&ReprojectionQualityParameters::max_range, 0.1f, "max_range is 0.1, must exceed min_range");
  ReprojectionQualityParameters parameters;
  parameters.coverage_step = 0;
  refusal::expectThrow([&] { reprojectionQuality(onEveryRay(1.0f), scene.rig, parameters); }, {"coverage_step is 0"});
}

TEST(QualityMeasure, DoesNotDependOnTheNumberOfThreads) {
  Scene scene = scenes::makeScene(scenes::cameraRow(3), scenes::ballAndWall());
  scenes::addNoise(scene, 0.005f);
  const scenes::Cloud cloud = scenes::fuse(scene.rig);
  const ReprojectionQuality one = reprojectionQuality(cloud, scene.rig, {}, 1);
  const ReprojectionQuality three = reprojectionQuality(cloud, scene.rig, {}, 3);
  EXPECT_EQ(one.error, three.error);
  EXPECT_EQ(one.multi_view_error, three.multi_view_error);
  EXPECT_EQ(one.covered_pixels, three.covered_pixels);
  EXPECT_EQ(one.violating_points, three.violating_points);
}

}  // namespace
