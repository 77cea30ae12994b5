#include "../scenes.h"

namespace {

using fuse_flow::Camera;
using fuse_flow::FrameStatistics;
using fuse_flow::FuseFlow;
using fuse_flow::FuseFlowParameters;
using fuse_flow::PointFused;
using scenes::Cloud;
using scenes::Scene;

/** \brief A ball before a slanted wall with noise: depth edges, hidden places and disagreement. */
Scene noisyScene(int cameras = 4, int width = 160, int height = 120) {
  Scene scene = scenes::makeScene(scenes::cameraRow(cameras, width, height, 0.94f * static_cast<float>(width)),
                                  scenes::ballAndWall());
  scenes::addNoise(scene, 0.003f);
  scene.color.resize(scene.depth.size());
  unsigned int value = 1;
  for (auto& image : scene.color) {
    image.resize(width, height);
    for (auto& pixel : image.data) {
      value = value * 1664525u + 1013904223u;
      pixel = {static_cast<std::uint8_t>(value >> 24), static_cast<std::uint8_t>(value >> 16),
               static_cast<std::uint8_t>(value >> 8)};
    }
  }
  scene.attach();
  return scene;
}

/** \brief The scene's float depth as integers of scale metres. */
void useIntegerDepth(Scene& scene, const std::vector<std::vector<std::uint16_t>>& raw, float scale) {
  scene.depth16.resize(scene.depth.size());
  for (std::size_t i = 0; i < scene.depth.size(); ++i) {
    scene.depth16[i].resize(scene.depth[i].width, scene.depth[i].height);
    scene.depth16[i].data = raw[i];
  }
  scene.attach();
  for (Camera& camera : scene.rig.cameras) camera.depth_scale = scale;
}

TEST(FuseFlowProperties, TheBytesDoNotDependOnTheNumberOfThreads) {
  const Scene scene = noisyScene(scenes::kSanitized ? 3 : 5, 320, 240);  // several tasks a view
  for (const bool hash : {true, false})
    for (FuseFlowParameters parameters : {FuseFlowParameters(), FuseFlowParameters::published()}) {
      parameters.use_spatial_hash = hash;
      const auto expected = scenes::bytes(scenes::fuse(scene.rig, parameters, 1));
      ASSERT_GT(expected.size(), 5000u);
      const std::vector<unsigned int> numbers = scenes::kSanitized ? std::vector{3u} : std::vector{2u, 3u, 7u, 0u};
      for (const unsigned int threads : numbers)
        ASSERT_TRUE(scenes::bytes(scenes::fuse(scene.rig, parameters, threads)) == expected) << threads << " threads";
    }
}

TEST(FuseFlowProperties, EveryRunGivesTheSameBytes) {
  const Scene scene = noisyScene(4, 320, 240);
  const auto expected = scenes::bytes(scenes::fuse(scene.rig, {}, 3));
  FuseFlow<PointFused> fusion;
  fusion.setNumberOfThreads(3);
  Cloud cloud;
  for (int run = 0; run < (scenes::kSanitized ? 2 : 8); ++run) {
    fusion.fuse(scene.rig, cloud);
    ASSERT_TRUE(scenes::bytes(cloud) == expected) << "run " << run;
  }
}

TEST(FuseFlowProperties, TheOrderOfTheCamerasDoesNotChangeThePoints) {
  const Scene scene = noisyScene(4);
  FrameStatistics expected, statistics;
  const Cloud cloud = scenes::fuse(scene.rig, {}, 2, &expected);
  fuse_flow::RigFrame shuffled;
  for (const std::size_t i : {2u, 0u, 3u, 1u}) {
    shuffled.cameras.push_back(scene.rig.cameras[i]);
    shuffled.views.push_back(scene.rig.views[i]);
  }
  const Cloud other = scenes::fuse(shuffled, {}, 2, &statistics);
  EXPECT_EQ(statistics.coarse_cells, expected.coarse_cells);
  EXPECT_EQ(statistics.gated_points, expected.gated_points);
  EXPECT_EQ(other.size(), cloud.size());
  EXPECT_EQ(scenes::withoutPartner(cloud, other, 2e-6f), 0u);
  EXPECT_EQ(scenes::withoutPartner(other, cloud, 2e-6f), 0u);
}

TEST(FuseFlowProperties, AMotionThatMapsTheCellsOntoThemselvesMovesTheCloudWithIt) {
  const Scene scene = noisyScene(4);
  const FuseFlowParameters parameters;
  const Cloud cloud = scenes::fuse(scene.rig, parameters);

  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  motion.linear() << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  motion.translation() = static_cast<double>(parameters.aggregation.cell_size) * Eigen::Vector3d(-7, 3, -41);
  fuse_flow::RigFrame moved = scene.rig;
  for (fuse_flow::Camera& camera : moved.cameras) camera.T_world_camera = motion * camera.T_world_camera;
  Cloud expected = cloud;
  for (auto& point : expected) point.getVector3fMap() = (motion * point.getVector3fMap().cast<double>()).cast<float>();
  const Cloud other = scenes::fuse(moved, parameters);

  // A point that rounding moves across a cell's side changes two fused points: one in a thousand at the very most.
  EXPECT_NEAR(static_cast<double>(other.size()), static_cast<double>(cloud.size()),
              1e-3 * static_cast<double>(cloud.size()));
  EXPECT_LE(scenes::withoutPartner(expected, other, 5e-6f), cloud.size() / 500);
  EXPECT_LE(scenes::withoutPartner(other, expected, 5e-6f), cloud.size() / 500);
}

TEST(FuseFlowProperties, DepthIsTheSameInMillimetresInQuartersOfThemAndInMetres) {
  Scene scene = noisyScene(3);
  std::vector<std::vector<std::uint16_t>> millimetres(3), quarters(3);
  for (std::size_t i = 0; i < 3; ++i)
    for (float& z : scene.depth[i].data) {
      const auto raw = static_cast<std::uint16_t>(std::lround(1000 * z));
      millimetres[i].push_back(raw);
      quarters[i].push_back(static_cast<std::uint16_t>(4 * raw));
      z = 0.001f * static_cast<float>(raw);  // a quarter is exact in binary: all three are the same floats
    }
  scene.attach();
  const auto metres = scenes::bytes(scenes::fuse(scene.rig));
  ASSERT_GT(metres.size(), 1000u);
  useIntegerDepth(scene, millimetres, 0.001f);
  EXPECT_TRUE(scenes::bytes(scenes::fuse(scene.rig)) == metres);
  useIntegerDepth(scene, quarters, 0.25f * 0.001f);
  EXPECT_TRUE(scenes::bytes(scenes::fuse(scene.rig)) == metres);
}

TEST(FuseFlowProperties, RowsMayBePadded) {
  const Scene scene = noisyScene(2);
  const auto expected = scenes::bytes(scenes::fuse(scene.rig));
  const int w = 160, h = 120, wide = w + 13;
  std::vector<std::vector<float>> depth(2);
  std::vector<std::vector<fuse_flow::Rgb8>> color(2);
  fuse_flow::RigFrame padded = scene.rig;
  for (std::size_t i = 0; i < 2; ++i) {
    depth[i].assign(static_cast<std::size_t>(wide * h), 0.7f);  // would be a measurement
    color[i].assign(static_cast<std::size_t>(wide * h), {255, 0, 255});
    for (int v = 0; v < h; ++v)
      for (int u = 0; u < w; ++u) {
        depth[i][static_cast<std::size_t>(v * wide + u)] = scene.depth[i].at(u, v);
        color[i][static_cast<std::size_t>(v * wide + u)] = scene.color[i].at(u, v);
      }
    padded.views[i].depth32 = {depth[i].data(), w, h, sizeof(float) * static_cast<std::size_t>(wide)};
    padded.views[i].color = {color[i].data(), w, h, sizeof(fuse_flow::Rgb8) * static_cast<std::size_t>(wide)};
  }
  EXPECT_TRUE(scenes::bytes(scenes::fuse(padded)) == expected);
}

TEST(FuseFlowProperties, OnlyDepthInRangeIsMeasuredAndItsEndsAreInRange) {
  Scene scene = scenes::makeFlatScene(scenes::sameCameras(1, 6, 1, 40), {1.0f});
  scene.depth[0].data = {0.499f, 0.5f, 1.0f, 2.0f, 2.001f, 0.0f};
  FuseFlowParameters parameters;
  parameters.preprocessing.min_range = 0.5f;
  parameters.preprocessing.max_range = 2.0f;
  parameters.use_measurement_confidence = false;
  FrameStatistics statistics;
  const Cloud cloud = scenes::fuse(scene.rig, parameters, 1, &statistics);
  EXPECT_EQ(statistics.measured_points, 3u);
  EXPECT_EQ(cloud.size(), 3u);  // far apart: three cells
  for (const auto& point : cloud) EXPECT_TRUE(point.z >= 0.5f && point.z <= 2.0f) << point.z;
}

TEST(FuseFlowProperties, NothingOutsideTheCropBoxIsFusedAndEverythingInsideIs) {
  const Scene scene = noisyScene(3);
  FuseFlowParameters parameters;
  parameters.use_measurement_confidence = false;
  parameters.smoothing.passes = 0;  // the refined points are not those counted below
  parameters.crop_box.emplace(Eigen::Vector3f(-0.2f, -0.15f, 0.5f), Eigen::Vector3f(0.3f, 0.2f, 1.6f));
  std::size_t inside = 0, at_the_side = 0;
  for (const scenes::Vector3d& p : scenes::backProjected(scene)) {
    const double distance = parameters.crop_box->cast<double>().exteriorDistance(p);
    inside += distance == 0 ? 1 : 0;
    at_the_side += distance > 0 && distance < 1e-6 ? 1 : 0;
  }
  FrameStatistics statistics;
  const Cloud cloud = scenes::fuse(scene.rig, parameters, 2, &statistics);
  ASSERT_GT(inside, 1000u);
  EXPECT_NEAR(static_cast<double>(statistics.gated_points), static_cast<double>(inside),
              static_cast<double>(at_the_side + 2));
  EXPECT_EQ(statistics.measured_points, 3u * 160u * 120u);
  ASSERT_GT(cloud.size(), 100u);
  for (const auto& point : cloud)  // a mean of points in a box is in the box
    ASSERT_LT(parameters.crop_box->exteriorDistance(Eigen::Vector3f(point.getVector3fMap())), 1e-6f);
}

TEST(FuseFlowProperties, MinimumWeightDropsExactlyThePointsBelowIt) {
  const Scene scene = noisyScene(4);
  FuseFlowParameters parameters;
  parameters.aggregation.min_weight = parameters.aggregation.weak_weight = 0;
  const Cloud all = scenes::fuse(scene.rig, parameters);
  parameters.aggregation.min_weight = 0.8f;
  const Cloud kept = scenes::fuse(scene.rig, parameters);
  Cloud expected;
  for (const auto& point : all)
    if (point.confidence >= 0.8f) expected.push_back(point);
  ASSERT_LT(expected.size(), all.size());
  ASSERT_FALSE(expected.empty());
  EXPECT_TRUE(scenes::bytes(kept) == scenes::bytes(expected));
}

TEST(FuseFlowProperties, WeakPointsGoOnlyWhereABetterOneStays) {
  // A wall with half its measurements doubtful: they thin out where nothing else is, and never crowd out the others.
  Scene scene = scenes::makeScene(scenes::sameCameras(1, 96, 72, 90), scenes::plane({0, 0, 1}, 1.5));
  scene.confidence.push_back(scenes::uniform(96, 72, 1.0f));
  for (int v = 0; v < 72; ++v)
    for (int u = 0; u < 48; ++u) scene.confidence[0].at(u, v) = 0.2f;
  scene.attach();
  FuseFlowParameters parameters;
  parameters.min_confidence = 0;
  parameters.aggregation.min_weight = parameters.aggregation.weak_weight = 0;
  const auto halves = [](const Cloud& cloud) {
    std::array<std::size_t, 2> count{};
    for (const auto& point : cloud) count[point.x > 0.1f ? 1 : 0] += std::abs(point.x) > 0.1f ? 1 : 0;
    return count;
  };
  const auto before = halves(scenes::fuse(scene.rig, parameters));
  parameters.aggregation.weak_weight = 0.25f;
  const auto after = halves(scenes::fuse(scene.rig, parameters));
  EXPECT_GT(after[1], before[1] * 9 / 10);  // at the image's border they are doubtful too
  EXPECT_LT(after[0], before[0] / 2);
  EXPECT_GT(after[0], before[0] / 30);  // at least one of each 27
}

TEST(FuseFlowProperties, AnUnsplitCellGivesOnePointAtMostAndItLiesInside) {
  // Unsplit cells: one point a cell at most, and in it, unless other views draw it out.
  const Scene scene = noisyScene(3);
  FuseFlowParameters parameters;
  parameters.aggregation.confirmation_reach = 0;
  parameters.aggregation.min_cell_size = parameters.aggregation.cell_size;
  FrameStatistics statistics;
  const Cloud cloud = scenes::fuse(scene.rig, parameters, 2, &statistics);
  EXPECT_LE(cloud.size(), statistics.coarse_cells);
  std::vector<std::array<int, 3>> cells;
  for (const auto& point : cloud)
    cells.push_back({static_cast<int>(std::floor(point.x / 0.064f)), static_cast<int>(std::floor(point.y / 0.064f)),
                     static_cast<int>(std::floor(point.z / 0.064f))});
  std::sort(cells.begin(), cells.end());
  EXPECT_TRUE(std::adjacent_find(cells.begin(), cells.end()) == cells.end());
}

TEST(FuseFlowProperties, AveragingOverUnsplitCellsBringsANoisyWallMuchNearerToTheTruth) {
  // A cell of 64 mm holds some 40 pixels of each camera, and the wall lies 28 mm from its sides, so that no noise leaves it.
  Scene scene = scenes::makeScene(scenes::cameraRow(4, 160, 120, 150), scenes::plane({0, 0, 1}, 1.5));
  scenes::addNoise(scene, 0.004f);
  FuseFlowParameters parameters;
  parameters.aggregation.min_cell_size = parameters.aggregation.cell_size;
  const Cloud cloud = scenes::fuse(scene.rig, parameters);
  ASSERT_GT(cloud.size(), 100u);
  double sum = 0;
  for (const auto& point : cloud) sum += std::pow(static_cast<double>(point.z) - 1.5, 2);
  EXPECT_LT(std::sqrt(sum / static_cast<double>(cloud.size())), 0.004 / 4);
}

}  // namespace
