#include "../refusal.h"
#include "wrong_sensors.h"

#include <fuse_flow/calibration/extrinsic_estimation.h>
#include <fuse_flow/filters/depth_backprojection.h>
#include <fuse_flow/quality/reprojection_quality.h>

#include <pcl/point_types.h>

// Sensors that measure wrong, and the correction that puts it right.

namespace {

using namespace fuse_flow;
using namespace scenes;
using refusal::expectThrow;

DepthCorrection uniformCorrection(float relative, float per_metre) {
  return {2, 2, std::vector<float>(4, relative), std::vector<float>(4, per_metre)};
}

/** \brief 3 × 2 knots, all different. */
DepthCorrection crooked() {
  return {3, 2, {0.01f, -0.02f, 0.03f, 0.0f, 0.015f, -0.01f}, {0.002f, 0.0f, -0.004f, 0.003f, -0.002f, 0.001f}};
}

TEST(DepthCorrection, IsAScaleAndAShareThatGrowsWithDepth) {
  EXPECT_FLOAT_EQ(correctedDepth(2.0f, {0.01f, 0.003f}), 2.0f + 0.02f + 0.012f);
  EXPECT_FLOAT_EQ(correctedDepth(2.0f, {}), 2.0f);
  EXPECT_EQ(correctedDepth(0.0f, {0.5f, 0.5f}), 0.0f);
  EXPECT_EQ(correctedDepth(10.0f, {0.0f, -0.2f}), 0.0f);  // nothing is behind the camera
}

TEST(DepthCorrection, HoldsItsKnotsAtTheCornersOfTheImageAndIsLinearBetween) {
  const DepthCorrection c = crooked();
  const int w = 101, h = 51;
  EXPECT_FLOAT_EQ(c.at(0, 0, w, h).relative, 0.01f);
  EXPECT_FLOAT_EQ(c.at(50, 0, w, h).relative, -0.02f);
  EXPECT_FLOAT_EQ(c.at(100, 0, w, h).relative, 0.03f);
  EXPECT_FLOAT_EQ(c.at(0, 50, w, h).relative, 0.0f);
  EXPECT_FLOAT_EQ(c.at(100, 50, w, h).relative, -0.01f);
  EXPECT_FLOAT_EQ(c.at(100, 0, w, h).per_metre, -0.004f);
  EXPECT_FLOAT_EQ(c.at(25, 0, w, h).relative, 0.5f * (0.01f - 0.02f));
  EXPECT_FLOAT_EQ(c.at(75, 25, w, h).relative, 0.25f * (-0.02f + 0.03f + 0.015f - 0.01f));
  EXPECT_FLOAT_EQ(c.at(0, 0, 1, 1).relative, 0.01f);  // an image of one pixel
  EXPECT_EQ(DepthCorrection().at(3, 4, w, h).relative, 0.0f);
}

TEST(DepthCorrection, BetweenTheKnotsOfEachCell) {
  // 4 × 3 knots, and numbers behind them that no place may reach.
  const float knots[] = {0, 1, 3, 7, 10, 20, 40, 80, 500, 600, 800, 1200, 9e9f, 9e9f, 9e9f, 9e9f};
  const auto at = [&knots](float x, float y) { return betweenKnots(knots, 4, 3, x, y); };
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 4; ++i)
      EXPECT_EQ(at(static_cast<float>(i), static_cast<float>(j)), knots[4 * j + i]) << i << ", " << j;
  EXPECT_EQ(at(0.5f, 0), 0.5f);
  EXPECT_EQ(at(2.5f, 1), 60);
  EXPECT_EQ(at(3, 1.5f), 640);
  EXPECT_EQ(at(0, 0.5f), 5);
  EXPECT_EQ(at(1.5f, 1.5f), (20 + 40 + 600 + 800) / 4);
}

TEST(DepthCorrection, APutRightSensorGivesTheCloudOfARightOne) {
  const Scene truth = makeScene(cameraRow(3), ballAndWall());
  Scene wrong = makeScene(cameraRow(3), ballAndWall());
  distort(wrong, crooked());
  const Cloud expected = fuse(truth.rig), corrected = fuse(wrong.rig);
  ASSERT_GT(expected.size(), 1000u);
  // Where rounding moves a point over a cell's border, it is alone; the ball's rim is sharp.
  EXPECT_LE(withoutPartner(expected, corrected, 1e-5f), expected.size() / 200);
  EXPECT_LE(withoutPartner(corrected, expected, 1e-5f), expected.size() / 200);
  for (Camera& camera : wrong.rig.cameras) camera.depth_correction = {};
  EXPECT_GT(withoutPartner(expected, fuse(wrong.rig), 1e-3f), expected.size() / 2) << "there is nothing to correct";
}

TEST(DepthCorrection, ReachesEveryClassThatReadsDepth) {
  const Scene truth = makeScene(cameraRow(3), ballAndWall());
  Scene wrong = makeScene(cameraRow(3), ballAndWall());
  distort(wrong, crooked());
  // Back-projection, of a view and of a cloud.
  DepthBackprojection<pcl::PointXYZ> backprojection;
  pcl::PointCloud<pcl::PointXYZ> points;
  backprojection.setCamera(wrong.rig.cameras[1]);
  backprojection.setView(wrong.rig.views[1]);
  backprojection.filter(points);
  const std::vector<Vector3d> all = backProjected(truth);
  const std::size_t pixels = wrong.depth[1].data.size();
  ASSERT_EQ(points.size(), pixels);
  for (std::size_t k = 0; k < pixels; ++k)
    ASSERT_LT((points[k].getVector3fMap().cast<double>() - all[pixels + k]).norm(), 1e-5) << k;
  auto cloud = std::make_shared<pcl::PointCloud<pcl::PointXYZ>>(wrong.depth[1].width, wrong.depth[1].height);
  for (std::size_t k = 0; k < pixels; ++k) (*cloud)[k].z = wrong.depth[1].data[k];
  backprojection.setInputCloud(cloud);
  backprojection.filter(points);
  for (std::size_t k = 0; k < pixels; ++k)
    ASSERT_LT((points[k].getVector3fMap().cast<double>() - all[pixels + k]).norm(), 1e-5) << k;
  // The measure of a cloud against what was measured.
  const Cloud fused = fuse(truth.rig);
  const ReprojectionQuality expected = reprojectionQuality(fused, truth.rig),
                            measured = reprojectionQuality(fused, wrong.rig);
  EXPECT_NEAR(measured.error, expected.error, 1e-5);
  EXPECT_NEAR(measured.coverage(), expected.coverage(), 1e-3);
  // Poses.
  ExtrinsicEstimation<pcl::PointXYZ> estimation;
  estimation.addFrame(wrong.rig);
  EXPECT_LT(estimation.estimate().residual_before, 5e-4);
  for (Camera& camera : wrong.rig.cameras) camera.depth_correction = {};
  ExtrinsicEstimation<pcl::PointXYZ> uncorrected;
  uncorrected.addFrame(wrong.rig);
  EXPECT_GT(uncorrected.estimate().residual_before, 2e-3);
}

TEST(DepthCorrection, RangesAreOfWhatIsMeasured) {
  Scene scene = makeFlatScene(sameCameras(1, 32, 24, 30), {2.0f});
  scene.rig.cameras[0].depth_correction = uniformCorrection(0.1f, 0.0f);
  FuseFlowParameters parameters;
  parameters.preprocessing.max_range = 2.1f;
  const Cloud cloud = fuse(scene.rig, parameters);
  ASSERT_FALSE(cloud.empty());
  for (const PointFused& point : cloud) EXPECT_NEAR(point.z, 2.2f, 1e-5f);
  parameters.preprocessing.max_range = 1.9f;
  EXPECT_TRUE(fuse(scene.rig, parameters).empty());
}

TEST(DepthCorrection, ChangesFromFrameToFrame) {
  Scene scene = makeFlatScene(sameCameras(1, 32, 24, 30), {2.0f});
  FuseFlow<PointFused> fusion;
  Cloud cloud;
  for (const float relative : {0.0f, 0.05f, -0.05f, 0.0f}) {
    scene.rig.cameras[0].depth_correction = relative == 0 ? DepthCorrection() : uniformCorrection(relative, 0);
    fusion.fuse(scene.rig, cloud);
    ASSERT_FALSE(cloud.empty());
    for (const PointFused& point : cloud) ASSERT_NEAR(point.z, 2.0f * (1 + relative), 1e-5f);
  }
}

TEST(DepthCorrection, IsRefusedWithWhatIsWrong) {
  Scene scene = makeFlatScene(sameCameras(1, 32, 24, 30), {2.0f});
  DepthCorrection& correction = scene.rig.cameras[0].depth_correction;
  const auto refuses = [&](const std::vector<std::string>& parts) { expectThrow([&] { fuse(scene.rig); }, parts); };
  correction = {1, 2, {0, 0}, {0, 0}};
  refuses({"test camera", "depth_correction", "1x2", "2x2 to 64x64"});
  correction = {65, 2, std::vector<float>(130), std::vector<float>(130)};
  refuses({"65x2"});
  correction = uniformCorrection(0, 0);
  correction.relative.pop_back();
  refuses({"depth_correction.relative has 3 numbers, must be 4"});
  correction = uniformCorrection(0, 0);
  correction.per_metre[2] = std::nanf("");
  refuses({"depth_correction.per_metre has nan", "-0.5 to 0.5"});
  correction = uniformCorrection(0.6f, 0);
  refuses({"depth_correction.relative has 0.6"});
  correction = {};
  correction.relative = {0};
  refuses({"depth_correction"});
}

TEST(DepthCorrection, OtherCorrectionsAreAnotherCalibration) {
  const Scene scene = wall(2);
  RigFrame other = scene.rig;
  other.cameras[1].depth_correction = uniformCorrection(0.01f, 0);
  EXPECT_FALSE(sameCalibration(scene.rig.cameras[1], other.cameras[1]));
  ExtrinsicEstimation<pcl::PointXYZ> estimation;
  estimation.addFrame(scene.rig);
  expectThrow([&] { estimation.addFrame(other); }, {"test camera 1", "other intrinsics"});
}

}  // namespace
