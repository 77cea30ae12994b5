#include "../scenes.h"

#include <fuse_flow/filters/depth_backprojection.h>
#include <fuse_flow/fuse_flow.h>
#include <fuse_flow/point_types.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace {

using namespace fuse_flow;

// r − 0.4 r³ grows up to r = √(1 / 1.2) = 0.913, where it is 0.609: no ray ends at a pixel further out, and none that a lens has beyond.
constexpr double kFold = 0.91287, kReach = 0.60858;

/** \brief Two cameras beside each other, a wall at 1 m, and a lens that does not reach the corners of its images. */
scenes::Scene wall() {
  scenes::Scene scene = scenes::makeFlatScene(scenes::sameCameras(2, 80, 60, 60), {1.0f, 1.0f});
  for (Camera& camera : scene.rig.cameras) camera.intrinsics.distortion.k1 = -0.4f;
  return scene;
}

double radiusOf(const Intrinsics& K, int u, int v) {
  return std::hypot((u - static_cast<double>(K.cx)) / static_cast<double>(K.fx),
                    (v - static_cast<double>(K.cy)) / static_cast<double>(K.fy));
}

TEST(LensThatFoldsOver, PixelsWithoutARayMeasureNothing) {
  const scenes::Scene scene = wall();
  const Camera& camera = scene.rig.cameras[0];
  DepthBackprojection<pcl::PointXYZ> filter;
  filter.setCamera(camera);
  filter.setView(scene.rig.views[0]);
  pcl::PointCloud<pcl::PointXYZ> cloud;
  filter.filter(cloud);
  ASSERT_EQ(cloud.width, 80u);
  int without = 0;
  for (int v = 0; v < 60; ++v)
    for (int u = 0; u < 80; ++u) {
      const double radius = radiusOf(camera.intrinsics, u, v);
      if (std::abs(radius - kReach) < 0.01) continue;  // within half a pixel of the fold
      const pcl::PointXYZ& p = cloud(static_cast<std::size_t>(u), static_cast<std::size_t>(v));
      const bool measured = std::isfinite(p.z);
      EXPECT_EQ(measured, radius < kReach) << u << ' ' << v;
      without += measured ? 0 : 1;
      if (!measured) continue;
      const Eigen::Vector3d p_C = camera.T_world_camera.inverse() * p.getVector3fMap().cast<double>();
      const double r = std::hypot(p_C.x(), p_C.y());
      EXPECT_NEAR(r - 0.4 * r * r * r, radius, 1e-4) << u << ' ' << v;
      EXPECT_LT(r, kFold + 1e-3);
    }
  EXPECT_GT(without, 100);
}

TEST(LensThatFoldsOver, NoPointIsFusedWhereNoRayGoes) {
  for (const bool published : {false, true}) {
    scenes::Scene scene = wall();
    FuseFlow<PointFused> fusion;
    FuseFlowParameters parameters = published ? FuseFlowParameters::published() : FuseFlowParameters();
    parameters.preprocessing.fill_neighbours = 0;
    fusion.setParameters(parameters);
    pcl::PointCloud<PointFused> cloud;
    fusion.fuse(scene.rig, cloud);
    EXPECT_GT(cloud.size(), 500u);
    for (const PointFused& p : cloud) {
      double nearest = 1e9;
      for (const Camera& camera : scene.rig.cameras) {
        const Eigen::Vector3d p_C = camera.T_world_camera.inverse() * p.getVector3fMap().cast<double>();
        nearest = std::min(nearest, std::hypot(p_C.x(), p_C.y()) / p_C.z());
      }
      EXPECT_LT(nearest, kFold + 0.02);
    }
  }
}

TEST(LensThatFoldsOver, ADepthCorrectionStaysWhereThereAreRays) {
  scenes::Scene scene = wall();
  Camera& camera = scene.rig.cameras[0];
  camera.depth_correction.columns = camera.depth_correction.rows = 2;
  camera.depth_correction.relative.assign(4, 0.1f);
  camera.depth_correction.per_metre.assign(4, 0.0f);
  DepthBackprojection<pcl::PointXYZ> filter;
  filter.setCamera(camera);
  filter.setView(scene.rig.views[0]);
  pcl::PointCloud<pcl::PointXYZ> cloud;
  filter.filter(cloud);
  const Eigen::Vector3d middle = camera.T_world_camera.inverse() * cloud(40, 30).getVector3fMap().cast<double>();
  EXPECT_NEAR(middle.z(), 1.1, 1e-5);
  EXPECT_FALSE(std::isfinite(cloud(0, 0).z));
}

}  // namespace
