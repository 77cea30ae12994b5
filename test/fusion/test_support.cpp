// Measurements that no neighbour continues.

#include "../scenes.h"

#include <random>

namespace {

using fuse_flow::ConfidenceParameters;
using fuse_flow::DepthPatch;
using fuse_flow::FrameStatistics;
using fuse_flow::FuseFlowParameters;
using scenes::Cloud;
using scenes::Scene;

/** \brief Of a camera with f = 500 pixels: neighbours on a surface at 1.3 rad, 2 m away, differ by 14.41 mm. */
int supportOf(const DepthPatch& depth, const DepthPatch& weight, float floor = 0.001f, float noise_scale = 1) {
  ConfidenceParameters p;
  p.noise = {floor, 0, 0};
  return fuse_flow::surfaceSupport(fuse_flow::slopeScale(p, 1.0f / 500, fuse_flow::viewNoise(p, nullptr)), noise_scale,
                                   depth, weight);
}

const DepthPatch kAll{{1, 1, 1, 1, 1, 1, 1, 1, 1}};

TEST(Support, IsWhatContinuesTheSurfaceUpToItsSteepestStepAndThreeDeviations) {
  const auto support = [](float step, std::size_t neighbour, float floor = 0.001f, float noise_scale = 1) {
    DepthPatch depth{{9, 9, 9, 9, 2, 9, 9, 9, 9}};
    depth.z[neighbour] = 2 + step;
    return supportOf(depth, kAll, floor, noise_scale);
  };
  for (const float sign : {-1.0f, 1.0f}) {
    for (const std::size_t straight : {1u, 3u, 5u, 7u}) {
      EXPECT_EQ(support(sign * 0.0173f, straight), 1);  // 14.4 and 3 mm
      EXPECT_EQ(support(sign * 0.0176f, straight), 0);
      EXPECT_EQ(support(sign * 0.0263f, straight, 0.004f), 1);
      EXPECT_EQ(support(sign * 0.0266f, straight, 0.004f), 0);
      EXPECT_EQ(support(sign * 0.0263f, straight, 0.001f, 4), 1);
      EXPECT_EQ(support(sign * 0.0266f, straight, 0.001f, 4), 0);
    }
    for (const std::size_t diagonal : {0u, 2u, 6u, 8u}) {
      EXPECT_EQ(support(sign * 0.0232f, diagonal), 1);  // 20.4 and 3 mm
      EXPECT_EQ(support(sign * 0.0236f, diagonal), 0);
    }
  }
}

TEST(Support, IsOfNeighboursThatPassTheGate) {
  const DepthPatch wall{{2, 2, 2, 2, 2, 2, 2, 2, 2}};
  EXPECT_EQ(supportOf(wall, kAll), 8);
  EXPECT_EQ(supportOf(wall, {{0, 0, 0, 0, 1, 0.01f, 0, 1, 0.5f}}), 3);  // a corner
  EXPECT_EQ(supportOf(wall, {{0, 0, 0, 0, 1, 0, 0, 0, 0}}), 0);
}

/** \brief One point for each measurement that is supported: every other gate is open. */
FuseFlowParameters supportAlone(int min_support) {
  FuseFlowParameters p;
  p.use_spatial_hash = p.use_distance_consistency = p.adapt_noise = false;
  p.smoothing.passes = 0;
  p.confidence.threshold = 0;
  p.max_noise = 0;
  p.min_support = min_support;
  return p;
}

constexpr float kBackground = 2, kIsland = 1;

/** \brief A camera that sees an island in front of a wall, from pixel (20, 10) on. */
Scene island(int width, int height) {
  Scene scene = scenes::makeFlatScene(scenes::sameCameras(1, 60, 40, 500), {kBackground});
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) scene.depth[0].at(20 + u, 10 + v) = kIsland;
  return scene;
}

std::size_t pointsOfIsland(int width, int height, int min_support) {
  const Cloud cloud = scenes::fuse(island(width, height).rig, supportAlone(min_support));
  return static_cast<std::size_t>(
      std::count_if(cloud.begin(), cloud.end(), [](const auto& point) { return point.z < 1.5f; }));
}

TEST(Support, DropsSpecksAndThreadsAndKeepsCorners) {
  EXPECT_EQ(pointsOfIsland(1, 1, 0), 1u);
  EXPECT_EQ(pointsOfIsland(1, 1, 1), 0u);
  EXPECT_EQ(pointsOfIsland(2, 1, 1), 2u);
  EXPECT_EQ(pointsOfIsland(5, 1, 1), 5u);
  EXPECT_EQ(pointsOfIsland(5, 1, 2), 3u);
  EXPECT_EQ(pointsOfIsland(1, 5, 2), 3u);
  EXPECT_EQ(pointsOfIsland(5, 1, 3), 0u);
  EXPECT_EQ(pointsOfIsland(2, 2, 3), 4u);
  EXPECT_EQ(pointsOfIsland(5, 4, 3), 20u);
  EXPECT_EQ(pointsOfIsland(5, 4, 4), 16u);
  EXPECT_EQ(pointsOfIsland(5, 4, 8), 6u);
}

TEST(Support, BeyondTheImageIsNone) {
  const Scene wall = scenes::makeFlatScene(scenes::sameCameras(1, 60, 40, 500), {2});
  EXPECT_EQ(scenes::fuse(wall.rig, supportAlone(3)).size(), 60u * 40);
  EXPECT_EQ(scenes::fuse(wall.rig, supportAlone(4)).size(), 60u * 40 - 4);
  EXPECT_EQ(scenes::fuse(wall.rig, supportAlone(6)).size(), 58u * 38);
}

TEST(Support, IsTheSameWhereverTheImageIsCutForThreads) {
  // Cut into stretches of some 32,000 pixels: this one into several, within the patches of three depths.
  Scene scene = scenes::makeFlatScene(scenes::sameCameras(1, 300, 400, 500), {2});
  std::mt19937 random(3);
  for (float& z : scene.depth[0].data) z = static_cast<float>(random() % 3 + 1);
  const auto& depth = scene.depth[0];
  for (const int min_support : {1, 2, 3, 5}) {
    std::vector<std::array<float, 3>> expected, found;
    for (int v = 0; v < depth.height; ++v)
      for (int u = 0; u < depth.width; ++u) {
        int support = 0;
        for (int b = std::max(v - 1, 0); b <= std::min(v + 1, depth.height - 1); ++b)
          for (int a = std::max(u - 1, 0); a <= std::min(u + 1, depth.width - 1); ++a)
            support += depth.at(a, b) == depth.at(u, v);
        const float z = depth.at(u, v);
        const fuse_flow::Vec3 p = fuse_flow::pointOnRay(
            fuse_flow::unproject(scene.rig.cameras[0].intrinsics, {static_cast<float>(u), static_cast<float>(v)}), z);
        if (support - 1 >= min_support) expected.push_back({p.x, p.y, p.z});
      }
    FrameStatistics statistics;
    const Cloud cloud = scenes::fuse(scene.rig, supportAlone(min_support), 2, &statistics);
    for (const auto& point : cloud) found.push_back({point.x, point.y, point.z});
    ASSERT_EQ(found.size(), expected.size()) << min_support;
    for (std::size_t k = 0; k < found.size(); ++k)
      for (std::size_t axis = 0; axis < 3; ++axis) ASSERT_NEAR(found[k][axis], expected[k][axis], 1e-5f) << k;
    EXPECT_EQ(statistics.measured_points, depth.data.size());
    EXPECT_EQ(statistics.gated_points, expected.size());
    EXPECT_EQ(scenes::bytes(scenes::fuse(scene.rig, supportAlone(min_support), 1)), scenes::bytes(cloud));
  }
}

TEST(Support, IsNotTakenByTheCropBox) {
  const Scene wall = scenes::makeFlatScene(scenes::sameCameras(1, 60, 40, 500), {2});
  FuseFlowParameters parameters = supportAlone(8);
  // From the left of pixel 30 on: half of the image, without its border.
  parameters.crop_box.emplace(Eigen::Vector3f(0, -1, 0), Eigen::Vector3f(1, 1, 3));
  EXPECT_EQ(scenes::fuse(wall.rig, parameters).size(), 29u * 38);
}

TEST(Support, OfMeasurementsIsAskedOnlyWithTheirConfidence) {
  FuseFlowParameters parameters = supportAlone(8);
  parameters.use_measurement_confidence = false;
  EXPECT_EQ(scenes::fuse(island(1, 1).rig, parameters).size(), 60u * 40);
}

}  // namespace
