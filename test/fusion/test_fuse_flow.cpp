#include "../scenes.h"

#include <fuse_flow/point_traits.h>

#include <pcl/common/point_tests.h>

#include <bitset>
#include <map>

namespace {

using fuse_flow::ConsistencyAt;
using fuse_flow::FrameStatistics;
using fuse_flow::FuseFlowParameters;
using fuse_flow::PointFused;
using fuse_flow::Representatives;
using scenes::Cloud;
using scenes::Scene;
using scenes::wall;

/** \brief Cells that are never split, so that every camera that looks at a place has points in its cell. */
FuseFlowParameters coarse() {
  FuseFlowParameters parameters;
  parameters.aggregation.min_cell_size = parameters.aggregation.cell_size;
  return parameters;
}

TEST(FuseFlow, PutsAFlatWallWhereItIs) {
  for (int cameras = 1; cameras <= 4; ++cameras) {
    const Cloud cloud = scenes::fuse(wall(cameras).rig);
    ASSERT_GT(cloud.size(), 1000u);
    for (const auto& point : cloud) {
      ASSERT_NEAR(point.z, 1.5f, 3e-6f);
      ASSERT_GT(point.confidence, 0.0f);
      ASSERT_LE(point.confidence, 1.0f);
    }
  }
}

TEST(FuseFlow, KeepsAUniformColorToTheBit) {
  for (const fuse_flow::Rgb8& color :
       {fuse_flow::Rgb8{201, 3, 77}, fuse_flow::Rgb8{255, 255, 255}, fuse_flow::Rgb8{0, 0, 0}}) {
    Scene scene = wall(3);
    scene.paint(color);
    const Cloud cloud = scenes::fuse(scene.rig);
    ASSERT_FALSE(cloud.empty());
    for (const auto& point : cloud) {
      ASSERT_EQ(point.r, color.r);
      ASSERT_EQ(point.g, color.g);
      ASSERT_EQ(point.b, color.b);
      ASSERT_EQ(point.a, 255);
    }
  }
}

TEST(FuseFlow, MixesTheColorsOfCamerasThatAgree) {
  Scene scene = scenes::makeFlatScene(scenes::sameCameras(2, 20, 20, 40), {1.0f, 1.0f});
  scene.paint({0, 0, 0});
  std::fill(scene.color[0].data.begin(), scene.color[0].data.end(), fuse_flow::Rgb8{200, 100, 0});
  const Cloud cloud = scenes::fuse(scene.rig);
  ASSERT_FALSE(cloud.empty());
  for (const auto& point : cloud) {  // equal C and V: half of each
    ASSERT_EQ(point.r, 100);
    ASSERT_EQ(point.g, 50);
    ASSERT_EQ(point.b, 0);
  }
}

TEST(FuseFlow, CountsAndNamesAllCamerasThatSeeAPlace) {
  for (int cameras = 1; cameras <= 6; ++cameras) {
    const Scene scene = scenes::makeScene(scenes::sameCameras(cameras, 96, 72, 90), scenes::plane({0.2, 0.1, 1}, 1.5));
    for (const ConsistencyAt at : {ConsistencyAt::CellMean, ConsistencyAt::Representatives})
      for (const bool hash : {true, false}) {
        FuseFlowParameters parameters;
        parameters.aggregation.consistency_at = at;
        parameters.use_spatial_hash = hash;
        const auto cloud = scenes::fuse<fuse_flow::PointFusedCameras>(scene.rig, parameters);
        ASSERT_FALSE(cloud.empty());
        for (const auto& point : cloud) {
          ASSERT_EQ(point.view_count, static_cast<std::uint32_t>(cameras));
          ASSERT_EQ(point.camera_mask[0], (1u << cameras) - 1);
          ASSERT_EQ(point.camera_mask[1], 0u);
        }
      }
  }
}

TEST(FuseFlow, WithoutConsistencyThePapersThreeAreCounted) {
  const Scene scene = scenes::makeScene(scenes::sameCameras(5, 48, 36, 45), scenes::plane({0, 0, 1}, 1.5));
  FuseFlowParameters parameters;
  parameters.use_distance_consistency = false;  // no other view is asked
  const auto cloud = scenes::fuse<fuse_flow::PointFusedCameras>(scene.rig, parameters);
  ASSERT_FALSE(cloud.empty());
  for (const auto& point : cloud) {
    ASSERT_EQ(point.view_count, 3u);
    ASSERT_EQ(std::bitset<32>(point.camera_mask[0]).count(), 3u);
  }
}

TEST(FuseFlow, ACameraAgreesUpToOneSigma) {
  // σ is 20 mm. The last camera measures the wall behind, so far that its points fall into other cells.
  for (const auto& [behind, agrees] : std::map<float, bool>{{0.018f, true}, {0.022f, false}, {0.049f, false}}) {
    FuseFlowParameters parameters;
    parameters.adapt_noise = false;
    parameters.consistency.sigma_per_noise = 0;
    parameters.aggregation.confirmation_reach = 0;
    const Scene scene =
        scenes::makeFlatScene(scenes::sameCameras(5, 24, 18, 20), {1.2f, 1.2f, 1.2f, 1.2f, 1.2f + behind});
    std::size_t front = 0;
    for (const auto& point : scenes::fuse<fuse_flow::PointFusedCameras>(scene.rig, parameters)) {
      if (point.z > 1.2001f) continue;
      ++front;
      ASSERT_EQ(point.view_count, agrees ? 5u : 4u) << behind;
      ASSERT_EQ(point.isFrom(4), agrees) << behind;
      ASSERT_TRUE(point.isFrom(0) && point.isFrom(3));
    }
    EXPECT_GT(front, 100u);
  }
}

TEST(FuseFlow, CamerasFromNumber64OnAreCountedAndHaveNoBit) {
  const Scene scene = scenes::makeFlatScene(scenes::sameCameras(70, 12, 9, 10), std::vector<float>(70, 1.2f));
  FuseFlowParameters parameters;
  parameters.consistency.max_views = parameters.consistency.max_candidates = 70;
  const auto cloud = scenes::fuse<fuse_flow::PointFusedCameras>(scene.rig, parameters);
  ASSERT_FALSE(cloud.empty());
  for (const auto& point : cloud) {
    ASSERT_EQ(point.view_count, 70u);
    ASSERT_EQ(fuse_flow::point::getCameraMask(point), ~std::uint64_t{0});
  }
}

TEST(FuseFlow, TheCamerasOfAPointDoNotDependOnTheOrderOfTheRig) {
  Scene scene = scenes::makeScene(scenes::cameraRow(4), scenes::ballAndWall());
  scenes::addNoise(scene, 0.003f);
  const auto cloud = scenes::fuse<fuse_flow::PointFusedCameras>(scene.rig);
  std::reverse(scene.rig.cameras.begin(), scene.rig.cameras.end());
  std::reverse(scene.rig.views.begin(), scene.rig.views.end());
  const auto back = scenes::fuse<fuse_flow::PointFusedCameras>(scene.rig);
  const auto reversed = [](std::uint64_t mask) {
    return (mask & 1) << 3 | (mask & 2) << 1 | (mask & 4) >> 1 | (mask & 8) >> 3;
  };
  std::map<std::uint64_t, std::size_t> points, of_reversed;
  for (const auto& point : cloud) ++points[fuse_flow::point::getCameraMask(point)];
  for (const auto& point : back) ++of_reversed[reversed(fuse_flow::point::getCameraMask(point))];
  EXPECT_GT(points.size(), 4u);
  for (const auto& [mask, count] : points)
    EXPECT_NEAR(static_cast<double>(count), static_cast<double>(of_reversed[mask]), 0.02 * cloud.size() + 2) << mask;
}

TEST(FuseFlow, CountsOnlyTheCamerasWhoseImageReachesAPlace) {
  // Two cameras whose images of the wall overlap in the middle: |x| < 0.5 m, each half image 0.8 m wide.
  const std::vector<fuse_flow::Camera> cameras{scenes::lookAt({-0.3, 0, 0}, {-0.3, 0, 1}),
                                               scenes::lookAt({0.3, 0, 0}, {0.3, 0, 1})};
  const Scene scene = scenes::makeScene(cameras, scenes::plane({0, 0, 1}, 1.5));
  const double half = 1.5 * 47.5 / 90;  // of the image on the wall
  const double cell = 0.064;
  std::size_t both = 0, one = 0;
  for (const auto& point : scenes::fuse(scene.rig, coarse())) {
    const double x = std::abs(static_cast<double>(point.x));
    if (x < half - 0.3 - 2 * cell) {
      ASSERT_EQ(point.view_count, 2u) << point.x;
      ++both;
    } else if (x > half - 0.3 + 2 * cell) {
      ASSERT_EQ(point.view_count, 1u) << point.x;
      ++one;
    }
  }
  EXPECT_GT(both, 50u);
  EXPECT_GT(one, 50u);
}

TEST(FuseFlow, NormalsAreUnitAreThoseOfTheSurfaceAndFaceTheCameras) {
  const Eigen::Vector3d n = Eigen::Vector3d(0.25, -0.15, 1).normalized();
  const Scene scene = scenes::makeScene(scenes::cameraRow(3), scenes::plane(n, 1.5));
  fuse_flow::FuseFlow<pcl::PointXYZRGBNormal> fusion;
  fusion.setComputeNormals(true);
  pcl::PointCloud<pcl::PointXYZRGBNormal> cloud;
  fusion.fuse(scene.rig, cloud);
  ASSERT_GT(cloud.size(), 1000u);
  const double degree = std::acos(-1.0) / 180;
  for (const auto& point : cloud) {
    const Eigen::Vector3d found = point.getNormalVector3fMap().cast<double>();
    ASSERT_NEAR(found.norm(), 1.0, 1e-5);
    ASSERT_GT(found.dot(-n), std::cos(1 * degree));  // the cameras are on the side of −n
  }
  fusion.setComputeNormals(false);
  fusion.fuse(scene.rig, cloud);
  for (const auto& point : cloud) ASSERT_EQ(point.getNormalVector3fMap().norm(), 0.0f);
}

TEST(FuseFlow, NormalsThatAreNotKnownAreNanInACloudThatIsNotDense) {
  // Measurements two pixels apart: no one has a neighbour.
  Scene scene = scenes::makeFlatScene(scenes::sameCameras(1, 31, 21, 20), {1.0f});
  for (int v = 0; v < 21; ++v)
    for (int u = 0; u < 31; ++u)
      if (u % 2 || v % 2) scene.depth[0].at(u, v) = 0;
  FuseFlowParameters parameters;
  parameters.min_support = 0;
  parameters.confidence.threshold = 0;
  for (const bool hash : {true, false}) {
    parameters.use_spatial_hash = hash;
    fuse_flow::FuseFlow<pcl::PointXYZRGBNormal> fusion;
    fusion.setParameters(parameters);
    pcl::PointCloud<pcl::PointXYZRGBNormal> cloud;
    fusion.fuse(scene.rig, cloud);
    EXPECT_TRUE(cloud.is_dense) << "normals were not asked for";
    fusion.setComputeNormals(true);
    fusion.fuse(scene.rig, cloud);
    EXPECT_FALSE(cloud.is_dense);
    ASSERT_GT(cloud.size(), 50u);
    for (const auto& point : cloud) {
      ASSERT_TRUE(pcl::isFinite(point));
      ASSERT_TRUE(std::isnan(point.normal_x) && std::isnan(point.normal_y) && std::isnan(point.normal_z));
    }
    fusion.fuse(wall(2).rig, cloud);  // of the next frame all are known
    EXPECT_TRUE(cloud.is_dense);
  }
}

TEST(FuseFlow, NormalsOfABallPointAwayFromItsCentre) {
  const Eigen::Vector3d centre(0, 0, 1.5);
  const Scene scene = scenes::makeScene(scenes::cameraRow(2, 160, 120, 200), scenes::sphere(centre, 0.4));
  fuse_flow::FuseFlow<pcl::PointXYZRGBNormal> fusion;
  FuseFlowParameters parameters;
  parameters.smoothing.wide_above =
      fuse_flow::kMaxNoiseScale;  // the ball curves so much in a pixel that it counts as noise
  fusion.setParameters(parameters);
  fusion.setComputeNormals(true);
  pcl::PointCloud<pcl::PointXYZRGBNormal> cloud;
  fusion.fuse(scene.rig, cloud);
  const double degree = std::acos(-1.0) / 180;
  double interior = 0, angles = 0, outside = 0;
  for (const auto& point : cloud) {
    const Eigen::Vector3d from_centre = point.getVector3fMap().cast<double>() - centre;
    const Eigen::Vector3d outward = from_centre.normalized();
    if (outward.z() > -0.7) continue;  // near the silhouette a pixel spans a large angle
    // Points of a cell of 8 mm are averaged: 8 mm / 0.4 m is 1.1 degrees; the smoothing flattens by less than another.
    const double cosine = point.getNormalVector3fMap().cast<double>().dot(outward);
    ASSERT_GT(cosine, std::cos(3.0 * degree));
    ++interior;
    angles += std::acos(std::min(cosine, 1.0)) / degree;
    outside += from_centre.norm() - 0.4;
  }
  EXPECT_GT(interior, 500);
  EXPECT_LT(angles / interior, 0.45);
  EXPECT_LT(std::abs(outside / interior), 0.0002);  // 2.6 mm inside without twicing
}

TEST(FuseFlow, FillsThePclHeaderAndTheStatistics) {
  Scene scene = wall(2);
  scene.rig.stamp = 1234567890123ull;
  FrameStatistics statistics;
  const Cloud cloud = scenes::fuse(scene.rig, {}, 2, &statistics);
  EXPECT_EQ(cloud.header.stamp, scene.rig.stamp);
  EXPECT_EQ(cloud.width, cloud.size());
  EXPECT_EQ(cloud.height, 1u);
  EXPECT_TRUE(cloud.is_dense);
  EXPECT_EQ(statistics.measured_points, 2u * 96u * 72u);
  EXPECT_EQ(statistics.fused_points, cloud.size());
  EXPECT_LE(statistics.gated_points, statistics.measured_points);
  EXPECT_GT(statistics.coarse_cells, 0u);
  EXPECT_TRUE(statistics.missing_cameras.empty());
}

// ---- Occlusion and free space

/** \brief Three cameras in front of a wall; a small board close to the first hides the wall's middle from it and from
 *  no other. */
Scene boardBeforeTheFirstCamera() {
  std::vector<fuse_flow::Camera> cameras;
  for (const double x : {0.0, 0.5, -0.5}) cameras.push_back(scenes::lookAt({x, 0, 0}, {x, 0, 1}));
  return scenes::makeScene(cameras, scenes::nearest({scenes::plane({0, 0, 1}, 1.5), scenes::square(0, 0, 0.4, 0.05)}));
}

/** \brief On the wall behind the board, well inside its shadow of ±0.05 · 1.5 / 0.4 m, where the other cameras look
 *  too. */
bool inTheShadow(const PointFused& point) {
  return std::abs(point.z - 1.5f) < 0.01f && std::abs(point.x) < 0.15f && std::abs(point.y) < 0.15f;
}

TEST(FuseFlow, AWallHiddenFromOneCameraStaysWithFullWeight) {
  const Scene scene = boardBeforeTheFirstCamera();
  ASSERT_NEAR(scene.depth[0].at(48, 36), 0.4f, 1e-6f);
  for (const std::size_t other : {std::size_t{1}, std::size_t{2}})  // the board is outside their images
    ASSERT_TRUE(
        std::all_of(scene.depth[other].data.begin(), scene.depth[other].data.end(), [](float z) { return z > 1.4f; }));
  std::size_t shadow = 0, board = 0;
  for (const auto& point : scenes::fuse(scene.rig)) {
    board += std::abs(point.z - 0.4f) < 1e-5f ? 1 : 0;
    if (!inTheShadow(point)) continue;
    ++shadow;
    ASSERT_GT(point.confidence, 0.99f);
  }
  EXPECT_GT(shadow, 200u);  // 0.3 m square in cells of 8 … 16 mm
  EXPECT_GT(board, 20u);
}

TEST(FuseFlow, WithThePublishedOcclusionFormAHiddenWallLosesWeight) {
  const Scene scene = boardBeforeTheFirstCamera();
  FuseFlowParameters parameters;
  parameters.consistency.occlusion = fuse_flow::OcclusionForm::Published;
  for (const auto& point : scenes::fuse(scene.rig, parameters))
    ASSERT_FALSE(inTheShadow(point));  // exp(−(1.1/0.02)²/2) is 0

  parameters.consistency.sigma = 1;  // one view agrees, one is off by 1.1 σ: V = exp(−1.21 / 2)
  std::size_t shadow = 0;
  for (const auto& point : scenes::fuse(scene.rig, parameters)) {
    if (!inTheShadow(point)) continue;
    ++shadow;
    ASSERT_NEAR(point.confidence, std::exp(-1.21 / 2), 0.01);
  }
  EXPECT_GT(shadow, 200u);
}

/** \brief Three cameras on a wall; in the first a patch of 7 × 7 pixels floats at 0.8 m, where the others see the wall
 *  behind. */
Scene floatingPatch() {
  const std::vector<fuse_flow::Camera> cameras{scenes::lookAt({0, 0, 0}, {0, 0, 1.5}),
                                               scenes::lookAt({0.3, 0, 0}, {0, 0, 1.5}),
                                               scenes::lookAt({-0.3, 0, 0}, {0, 0, 1.5})};
  Scene scene = scenes::makeScene(cameras, scenes::plane({0, 0, 1}, 1.5));
  for (int v = 33; v < 40; ++v)
    for (int u = 45; u < 52; ++u) scene.depth[0].at(u, v) = 0.8f;
  return scene;
}

std::size_t floating(const Cloud& cloud) {
  return static_cast<std::size_t>(
      std::count_if(cloud.begin(), cloud.end(), [](const auto& point) { return point.z < 1.4f; }));
}

TEST(FuseFlow, APatchThatTheOthersSeeThroughIsRemoved) {
  const Scene scene = floatingPatch();
  EXPECT_EQ(floating(scenes::fuse(scene.rig)), 0u);
  FuseFlowParameters blind;
  blind.use_distance_consistency = false;  // it is the consistency that removes it, not the confidence
  EXPECT_GE(floating(scenes::fuse(scene.rig, blind)), 9u);
}

TEST(FuseFlow, APatchThatNobodyElseCanJudgeStays) {
  Scene scene = floatingPatch();
  for (const std::size_t other : {std::size_t{1}, std::size_t{2}})
    std::fill(scene.depth[other].data.begin(), scene.depth[other].data.end(), 0.0f);
  EXPECT_GE(floating(scenes::fuse(scene.rig)), 9u);
}

TEST(FuseFlow, EachViewThatSeesThroughMultipliesTheWeightByThePenalty) {
  // At the same pose, 1 m against 1.5 m: the nearer is seen through by the other, the farther is hidden from the
  // nearer.
  FuseFlowParameters parameters;
  parameters.aggregation.min_weight = parameters.aggregation.weak_weight = 0;
  parameters.half_weight_noise = 0;
  parameters.consistency.free_space_penalty = 0.25f;
  for (int through = 1; through <= 2; ++through) {
    std::vector<float> depths(static_cast<std::size_t>(through), 1.5f);
    depths.push_back(1.0f);
    const Scene scene = scenes::makeFlatScene(scenes::sameCameras(through + 1, 1, 1, 40), depths);
    parameters.use_measurement_confidence = false;
    const Cloud cloud = scenes::fuse(scene.rig, parameters);
    ASSERT_EQ(cloud.size(), 2u);
    for (const auto& point : cloud) EXPECT_NEAR(point.confidence, point.z > 1.2f ? 1.0 : std::pow(0.25, through), 1e-6);
  }
}

/** \brief A board 30 mm thick, between a camera that sees its front at 1 m and one that sees its back at 1 m: the front's measurement is
 *  1.5 σ nearer to each than the other's. */
Scene thinBoard(const fuse_flow::Distortion& distortion = {}) {
  std::vector<fuse_flow::Camera> cameras{scenes::lookAt({0, 0, 0}, {0, 0, 1}, 41, 31, 40),
                                         scenes::lookAt({0, 0, 2.03}, {0, 0, 1}, 41, 31, 40)};
  for (fuse_flow::Camera& camera : cameras) camera.intrinsics.distortion = distortion;
  return scenes::makeFlatScene(cameras, {1.0f, 1.0f});
}

FuseFlowParameters equalWeights() {
  FuseFlowParameters parameters;
  parameters.use_measurement_confidence = false;
  parameters.aggregation.min_weight = parameters.aggregation.weak_weight = 0;
  parameters.aggregation.points_per_cell = 0.01f;  // a child for each pixel
  return parameters;
}

TEST(FuseFlow, BothSidesOfAThinBoardKeepTheirWeightAndTheirPlace) {
  fuse_flow::Distortion curved;
  curved.k1 = 0.05f;
  for (const fuse_flow::Distortion& distortion : {fuse_flow::Distortion{}, curved}) {
    const Scene board = thinBoard(distortion);
    for (const ConsistencyAt at : {ConsistencyAt::CellMean, ConsistencyAt::Representatives}) {
      FuseFlowParameters parameters = equalWeights();
      parameters.aggregation.consistency_at = at;
      std::size_t front = 0, back = 0;
      for (const auto& point : scenes::fuse(board.rig, parameters)) {
        (point.z < 1.015f ? front : back) += 1;
        ASSERT_NEAR(point.z, point.z < 1.015f ? 1.0f : 1.03f, 1e-5f);
        ASSERT_NEAR(point.confidence, 1.0f, 1e-6f);
        ASSERT_EQ(point.view_count, 1u);
      }
      EXPECT_GT(front, 1000u);
      EXPECT_GT(back, 1000u);
    }
  }
  // It is where the surface faces that makes the difference. At the edge of its image, the board is outside of the other's.
  FuseFlowParameters parameters = equalWeights();
  parameters.consistency.min_facing = -1;
  std::size_t contradicted = 0;
  const Cloud cloud = scenes::fuse(thinBoard().rig, parameters);
  for (const auto& point : cloud) contradicted += std::fabs(point.confidence - std::exp(-2.25f)) < 1e-3f ? 1 : 0;
  EXPECT_GT(contradicted, 9 * cloud.size() / 10);
}

TEST(FuseFlow, BothSidesOfAThinBoardStayWithoutTheSpatialHash) {
  FuseFlowParameters parameters = equalWeights();
  parameters.use_spatial_hash = false;
  const Cloud cloud = scenes::fuse(thinBoard().rig, parameters);
  EXPECT_EQ(cloud.size(), 2u * 41 * 31);
  for (const auto& point : cloud) ASSERT_NEAR(point.confidence, 1.0f, 1e-6f);
}

/** \brief A box 1 m before a wall of 1.5 m, seen by two cameras, whose calibration the second's image contradicts by so many columns: its
 *  box is narrower. */
Scene boxOfAnotherWidth(int columns) {
  Scene scene = scenes::makeFlatScene(scenes::sameCameras(2, 41, 31, 40), {1.5f, 1.5f});
  for (int v = 5; v < 26; ++v)
    for (int u = 10; u < 31; ++u) {
      scene.depth[0].at(u, v) = 1.0f;
      if (u >= 10 + columns && u <= 30 - columns) scene.depth[1].at(u, v) = 1.0f;
    }
  return scene;
}

TEST(FuseFlow, TheEdgeOfABoxStaysWherePosesAreAPixelOrTwoOff) {
  const auto seenThrough = [](int columns, int radius) {
    FuseFlowParameters parameters = equalWeights();
    parameters.consistency.silhouette_radius = radius;
    std::size_t n = 0;
    for (const auto& point : scenes::fuse(boxOfAnotherWidth(columns).rig, parameters))
      n += point.z < 1.2f && point.confidence < 0.5f ? 1 : 0;
    return n;
  };
  EXPECT_EQ(seenThrough(0, 0), 0u);
  EXPECT_EQ(seenThrough(1, 0), 2u * 21);
  EXPECT_EQ(seenThrough(2, 0), 4u * 21);
  EXPECT_EQ(seenThrough(2, 1), 2u * 21);  // the outer column
  EXPECT_EQ(seenThrough(2, 2), 0u);
  EXPECT_EQ(seenThrough(3, 2), 2u * 21);
}

// ---- The published equations, by hand

TEST(FuseFlow, PublishedParametersMeasureConfidenceByEquation3) {
  // One camera, one pixel that passes: ω = C. Its right neighbour is 2 cm farther: G = 1 cm, and of nine depths one is
  // off by 2 cm: σ = 2 √(1/9 · 8/9) cm = 0.6285 cm.
  Scene scene = scenes::makeFlatScene(scenes::sameCameras(1, 3, 3, 40), {1.0f});
  scene.depth[0].at(2, 1) = 1.02f;
  scene.confidence.push_back(scenes::uniform(3, 3, 0.0f));
  scene.confidence[0].at(1, 1) = 1;
  scene.attach();
  const double sigma = 2 * std::sqrt(8.0 / 81.0);
  const double C = (0.5 / (1 + 0.5 * 1.0) + 1.0 / (1 + sigma)) / 1.5;
  const Cloud cloud = scenes::fuse(scene.rig, FuseFlowParameters::published());
  ASSERT_EQ(cloud.size(), 1u);
  EXPECT_NEAR(cloud[0].confidence, C, 1e-4);
  EXPECT_NEAR(cloud[0].z, 1.0f, 1e-6f);
}

TEST(FuseFlow, PublishedParametersWeighTwoMeasurementsByEquations7And11) {
  // One pixel on the axis: 1.000 m with C = 1, 1.010 m with C = 0.5. Each is d = 1 cm off the other: V = exp(−(1/2)²).
  Scene scene = scenes::makeFlatScene(scenes::sameCameras(2, 1, 1, 40), {1.0f, 1.01f});
  scene.confidence = {scenes::uniform(1, 1, 1.0f), scenes::uniform(1, 1, 0.5f)};
  scene.attach();
  const Cloud cloud = scenes::fuse(scene.rig, FuseFlowParameters::published());
  const double V = std::exp(-0.25);
  ASSERT_EQ(cloud.size(), 1u);
  EXPECT_NEAR(cloud[0].z, (1 * V * 1.0 + 0.5 * V * 1.01) / (1 * V + 0.5 * V), 1e-6);
  EXPECT_NEAR(cloud[0].confidence, (V * V + 0.25 * V * V) / (1.5 * V), 1e-5);  // the mean ω weighted with ω
  EXPECT_EQ(cloud[0].view_count, 2u);
}

TEST(FuseFlow, PublishedParametersFuseTheThreeMostConfidentOfFour) {
  const std::vector<double> z{1.000, 1.006, 1.002, 1.004}, C{0.7, 0.9, 1.0, 0.8};
  Scene scene = scenes::makeFlatScene(scenes::sameCameras(4, 1, 1, 40), {1.0f, 1.006f, 1.002f, 1.004f});
  for (const double c : C) scene.confidence.push_back(scenes::uniform(1, 1, static_cast<float>(c)));
  scene.attach();
  double sum = 0, total = 0, squares = 0;
  for (std::size_t i = 1; i < 4; ++i) {  // the first is the least confident; it judges but does not contribute
    double d2 = 0;
    for (std::size_t j = 0; j < 4; ++j) d2 += (z[i] - z[j]) * (z[i] - z[j]) / 3;
    const double weight = C[i] * std::exp(-d2 / (0.02 * 0.02));
    sum += weight * z[i];
    total += weight;
    squares += weight * weight;
  }
  const Cloud cloud = scenes::fuse(scene.rig, FuseFlowParameters::published());
  ASSERT_EQ(cloud.size(), 1u);
  EXPECT_NEAR(cloud[0].z, sum / total, 1e-6);
  EXPECT_NEAR(cloud[0].confidence, squares / total, 1e-5);
  EXPECT_EQ(cloud[0].view_count, 4u);  // the fourth agrees
}

// ---- The sensor's own confidence

TEST(FuseFlow, WhatASensorIsHalfSureOfCountsHalf) {
  Scene scene = scenes::makeFlatScene(scenes::sameCameras(1, 41, 31, 40), {1.0f});
  scene.confidence.push_back(scenes::uniform(41, 31, 0.2f));  // below τ
  scene.attach();
  FuseFlowParameters parameters;
  parameters.min_confidence = 0.2f;
  parameters.gate_noise = 0;
  parameters.aggregation.min_weight = parameters.aggregation.weak_weight = 0;  // which look at weights
  ASSERT_GT(parameters.confidence.threshold, 0.2f);
  FrameStatistics statistics;
  const Cloud sure = scenes::fuse(scenes::makeFlatScene(scene.rig.cameras, {1.0f}).rig, parameters, 1);
  const Cloud cloud = scenes::fuse(scene.rig, parameters, 1, &statistics);
  ASSERT_EQ(cloud.size(), sure.size());
  for (std::size_t k = 0; k < cloud.size(); ++k) {
    ASSERT_NEAR(cloud[k].confidence, 0.2f * sure[k].confidence, 1e-6f);
    ASSERT_NEAR(cloud[k].x, sure[k].x, 1e-6f);
  }
  EXPECT_EQ(statistics.gated_points, 41u * 31u - 4u);  // C of a corner of the image is below τ, sure or not
}

TEST(FuseFlow, ConfidenceBelowItsOwnThresholdIsNoMeasurement) {
  Scene scene = scenes::makeFlatScene(scenes::sameCameras(1, 40, 30, 40), {1.0f});
  scene.confidence.push_back(scenes::uniform(40, 30, 0.5f));
  for (int v = 0; v < 30; ++v)
    for (int u = 0; u < 20; ++u) scene.confidence[0].at(u, v) = v < 15 ? 0.49f : std::nanf("");
  scene.attach();
  FuseFlowParameters parameters;
  parameters.min_support = 0;
  for (const bool measured : {true, false}) {
    parameters.use_measurement_confidence = measured;
    parameters.min_confidence = 0.5f;
    for (const auto& point : scenes::fuse(scene.rig, parameters)) ASSERT_GE(point.x, 0.0f);
    parameters.min_confidence = 0;
    std::size_t left = 0;
    for (const auto& point : scenes::fuse(scene.rig, parameters)) {
      ASSERT_TRUE(point.x > -1e-6f || point.y < 0.02f) << "of a pixel whose confidence is not a number";
      left += point.x < -0.01f ? 1 : 0;
    }
    EXPECT_GT(left, 50u);
  }
}

// ---- The crop box

TEST(FuseFlow, NoPointLiesOutsideTheCropBoxEvenWhereViewsConfirmOne) {
  Scene scene = scenes::makeScene(scenes::cameraRow(4), scenes::plane({0, 0, 1}, 1.5));
  scenes::addNoise(scene, 0.006f);
  FuseFlowParameters parameters;
  FrameStatistics statistics;
  parameters.crop_box = Eigen::AlignedBox3f(Eigen::Vector3f(-0.3f, -0.2f, 1.4f), Eigen::Vector3f(0.3f, 0.2f, 1.5f));
  const Cloud cloud = scenes::fuse(scene.rig, parameters, 2, &statistics);
  EXPECT_GT(cloud.size(), 500u);
  EXPECT_EQ(statistics.fused_points, cloud.size());
  for (const auto& point : cloud) ASSERT_TRUE(parameters.crop_box->contains(point.getVector3fMap())) << point.z;
  parameters.crop_box->max().z() = 1.6f;  // the whole wall: those behind are there
  std::size_t behind = 0;
  for (const auto& point : scenes::fuse(scene.rig, parameters)) behind += point.z > 1.5f ? 1 : 0;
  EXPECT_GT(behind, 500u);
}

// ---- Depth out of range

TEST(FuseFlow, DepthInAnotherUnitIsFoundWithWhatItWouldMean) {
  Scene scene = scenes::makeFlatScene(scenes::sameCameras(3, 40, 30, 40), {1.0f, 1500.0f, 2.0f});
  scene.depth16.resize(3);
  scene.depth16[2].resize(40, 30);
  std::fill(scene.depth16[2].data.begin(), scene.depth16[2].data.end(), std::uint16_t{25000});  // 2.5 m in 0.1 mm
  scene.depth16[2].at(3, 3) = 0;
  scene.depth16[2].at(4, 3) = 65535;
  scene.depth16[2].at(5, 3) = 30000;
  scene.depth[1].at(0, 0) = std::nanf("");
  scene.attach();
  FrameStatistics statistics;
  scenes::fuse(scene.rig, {}, 2, &statistics);
  ASSERT_EQ(statistics.out_of_range.size(), 2u);
  const fuse_flow::DepthOutOfRange &millimetres = statistics.out_of_range[0], &tenths = statistics.out_of_range[1];
  EXPECT_EQ(millimetres.camera, 1u);
  EXPECT_EQ(millimetres.measured, 1199u);
  EXPECT_EQ(millimetres.in_range, 0u);
  EXPECT_EQ(millimetres.nearest, 1500.0f);
  EXPECT_EQ(millimetres.farthest, 1500.0f);
  EXPECT_EQ(tenths.camera, 2u);
  EXPECT_EQ(tenths.measured, 1198u);
  EXPECT_FLOAT_EQ(tenths.nearest, 25.0f);
  EXPECT_FLOAT_EQ(tenths.farthest, 30.0f);
  scene.rig.cameras[2].depth_scale = 1e-4f;
  scenes::fuse(scene.rig, {}, 2, &statistics);
  EXPECT_EQ(statistics.out_of_range.size(), 1u);
}

TEST(FuseFlow, FewMeasurementsAreNoneOutOfRange) {
  Scene scene = scenes::makeFlatScene(scenes::sameCameras(1, 40, 30, 40), {0.0f});
  FrameStatistics statistics;
  scenes::fuse(scene.rig, {}, 2, &statistics);
  EXPECT_TRUE(statistics.out_of_range.empty()) << "nothing is measured";
  scene.depth[0].at(7, 7) = 1;
  scene.depth[0].at(8, 7) = 30;
  scenes::fuse(scene.rig, {}, 2, &statistics);
  EXPECT_TRUE(statistics.out_of_range.empty()) << "half of what is measured is in range";
}

// ---- The ablation's switches

TEST(FuseFlow, WithoutMeasurementConfidenceEveryMeasurementPassesTheGate) {
  Scene scene = scenes::makeScene(scenes::cameraRow(3), scenes::ballAndWall());
  scenes::addNoise(scene, 0.02f);
  FrameStatistics with, without;
  FuseFlowParameters parameters;
  scenes::fuse(scene.rig, parameters, 2, &with);
  parameters.use_measurement_confidence = false;
  scenes::fuse(scene.rig, parameters, 2, &without);
  EXPECT_LT(with.gated_points, with.measured_points);
  EXPECT_EQ(without.gated_points, without.measured_points);
}

TEST(FuseFlow, WithoutMeasurementConfidenceNoiseCostsNoWeight) {
  const Scene scene =
      scenes::makeFlatScene(scenes::sameCameras(1, 40, 30, 40), {8.0f});  // of more noise than max_noise
  FrameStatistics with, without;
  FuseFlowParameters parameters;
  parameters.use_distance_consistency = false;
  scenes::fuse(scene.rig, parameters, 1, &with);
  EXPECT_EQ(with.gated_points, 0u);
  parameters.use_measurement_confidence = false;
  const auto cloud = scenes::fuse(scene.rig, parameters, 1, &without);
  EXPECT_EQ(without.gated_points, 40u * 30u);
  ASSERT_FALSE(cloud.empty());
  for (const auto& point : cloud) EXPECT_EQ(point.confidence, 1.0f);
}

TEST(FuseFlow, WithoutDistanceConsistencyDisagreementCostsNoWeight) {
  const Scene scene = scenes::makeFlatScene(scenes::sameCameras(2, 1, 1, 40), {1.0f, 1.01f});
  FuseFlowParameters parameters = FuseFlowParameters::published();  // V at each representative
  parameters.use_measurement_confidence = false;
  const Cloud with = scenes::fuse(scene.rig, parameters);
  ASSERT_EQ(with.size(), 1u);
  EXPECT_NEAR(with[0].confidence, std::exp(-0.25), 1e-5);
  parameters.use_distance_consistency = false;
  const Cloud without = scenes::fuse(scene.rig, parameters);
  ASSERT_EQ(without.size(), 1u);
  EXPECT_NEAR(without[0].confidence, 1.0f, 1e-6f);
  EXPECT_NEAR(without[0].z, 1.005f, 1e-6f);
}

TEST(FuseFlow, WithoutTheHashEveryGatedPixelGivesOnePointBetweenTheViewsMeasurements) {
  const Scene scene = scenes::makeFlatScene(scenes::sameCameras(2, 20, 15, 40), {1.0f, 1.01f});
  FuseFlowParameters parameters;
  parameters.use_measurement_confidence = false;
  parameters.use_spatial_hash = false;
  parameters.half_weight_noise = 0;
  FrameStatistics statistics;
  const Cloud cloud = scenes::fuse(scene.rig, parameters, 2, &statistics);
  ASSERT_EQ(cloud.size(), 2u * 20u * 15u);
  EXPECT_EQ(statistics.gated_points, cloud.size());
  EXPECT_EQ(statistics.fused_points, cloud.size());
  for (const auto& point : cloud) {  // both weigh exp(−(1/2)²)
    ASSERT_NEAR(point.z, 1.005f, 2e-6f);
    ASSERT_NEAR(point.confidence, std::exp(-0.25), 1e-4);
    ASSERT_EQ(point.view_count, 2u);
  }
  EXPECT_NEAR(cloud[21].x, 1.005 * (1 - 9.5) / 40, 1e-5);  // row 1, column 1 of the first camera: pixels in their order
  EXPECT_NEAR(cloud[21].y, 1.005 * (1 - 7.0) / 40, 1e-5);

  parameters.use_distance_consistency = false;  // then no view knows of the other
  std::size_t nearer = 0;
  for (const auto& point : scenes::fuse(scene.rig, parameters)) nearer += std::abs(point.z - 1.0f) < 1e-6f ? 1 : 0;
  EXPECT_EQ(nearer, 20u * 15u);
}

TEST(FuseFlow, AllEightAblationsRun) {
  Scene scene = scenes::makeScene(scenes::cameraRow(3), scenes::ballAndWall());
  scenes::addNoise(scene, 0.003f);
  scene.paint({10, 20, 30});
  for (int switches = 0; switches < 8; ++switches) {
    FuseFlowParameters parameters;
    parameters.use_measurement_confidence = switches & 1;
    parameters.use_distance_consistency = switches & 2;
    parameters.use_spatial_hash = switches & 4;
    FrameStatistics statistics;
    const Cloud cloud = scenes::fuse(scene.rig, parameters, 2, &statistics);
    ASSERT_GT(cloud.size(), 1000u) << switches;
    EXPECT_LE(cloud.size(), statistics.gated_points) << switches;
    for (const auto& point : cloud) {
      ASSERT_TRUE(point.getVector3fMap().allFinite()) << switches;
      ASSERT_GT(point.confidence, 0.0f) << switches;
      ASSERT_LE(point.confidence, 1.0f) << switches;
      ASSERT_EQ(point.g, 20) << switches;
    }
  }
}

}  // namespace
