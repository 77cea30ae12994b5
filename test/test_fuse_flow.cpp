#include "scenes.h"

namespace {

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

TEST(FuseFlow, CountsTheCamerasThatSeeAPlaceUpToThePapersThree) {
  for (int cameras = 1; cameras <= 4; ++cameras) {
    const Scene scene = scenes::makeScene(scenes::sameCameras(cameras, 96, 72, 90), scenes::plane({0.2, 0.1, 1}, 1.5));
    const Cloud cloud = scenes::fuse(scene.rig);
    ASSERT_FALSE(cloud.empty());
    for (const auto& point : cloud) ASSERT_EQ(point.view_count, static_cast<std::uint32_t>(std::min(cameras, 3)));
  }
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
  std::size_t interior = 0;
  for (const auto& point : cloud) {
    const Eigen::Vector3d outward = (point.getVector3fMap().cast<double>() - centre).normalized();
    if (outward.z() > -0.7) continue;  // near the silhouette a pixel spans a large angle
    ++interior;
    // Points of a cell of 8 mm are averaged: 8 mm / 0.4 m is 1.1 degrees; the smoothing flattens by less than another.
    ASSERT_GT(point.getNormalVector3fMap().cast<double>().dot(outward), std::cos(3.0 * std::acos(-1.0) / 180));
  }
  EXPECT_GT(interior, 500u);
}

TEST(FuseFlow, WeightGoesToIntensityWhereThereIsNoConfidence) {
  Scene scene = scenes::makeFlatScene(scenes::sameCameras(1, 9, 9, 40), {1.0f});
  scene.confidence.push_back(scenes::uniform(9, 9, 0.75f));  // C = 0.75 inside the image
  scene.attach();
  FuseFlowParameters parameters;
  parameters.half_weight_noise = 0;
  std::size_t inside = 0;
  for (const auto& point : scenes::fuse<pcl::PointXYZI>(scene.rig, parameters))
    inside += std::abs(point.intensity - 0.75f) < 1e-4f ? 1 : 0;
  EXPECT_GT(inside, 10u);
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
  EXPECT_EQ(cloud[0].view_count, 3u);
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
