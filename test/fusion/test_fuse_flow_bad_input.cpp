#include "../refusal.h"
#include "../scenes.h"

namespace {

using fuse_flow::FrameStatistics;
using fuse_flow::FuseFlow;
using fuse_flow::FuseFlowParameters;
using fuse_flow::PointFused;
using refusal::expectMentions;
using refusal::messageOf;
using scenes::Cloud;
using scenes::Scene;
using scenes::wall;

void expectRefused(const Scene& scene, const std::vector<std::string>& parts) {
  expectMentions(messageOf([&] { scenes::fuse(scene.rig); }), parts);
}

TEST(FuseFlowBadInput, AFrameWithoutCamerasIsRefused) { expectRefused(Scene(), {"RigFrame", "no camera"}); }

TEST(FuseFlowBadInput, AFrameWithMoreCamerasThanViewsIsRefusedWithBothNumbers) {
  Scene scene = wall(3);
  scene.rig.views.pop_back();
  expectRefused(scene, {"RigFrame", "3 cameras", "2 views"});
}

TEST(FuseFlowBadInput, ACameraThatCannotBeIsRefusedByItsNameAndTheValue) {
  Scene scene = wall(2);
  scene.rig.cameras[1].name = "left door";
  scene.rig.cameras[1].intrinsics.fx = 0;
  expectRefused(scene, {"left door", "fx is 0"});
  scene.rig.cameras[1].intrinsics.fx = 90;
  scene.rig.cameras[1].intrinsics.fy = -3;
  expectRefused(scene, {"left door", "fy is -3"});
  scene.rig.cameras[1].intrinsics.fy = 90;
  scene.rig.cameras[1].intrinsics.cx = std::numeric_limits<float>::quiet_NaN();
  expectRefused(scene, {"left door", "cx is", "finite"});
  scene.rig.cameras[1].intrinsics.cx = 40;
  scene.rig.cameras[1].intrinsics.height = 0;
  expectRefused(scene, {"left door", "96x0"});
}

TEST(FuseFlowBadInput, APoseThatIsNotRigidIsRefused) {
  for (const Eigen::Matrix3d& wrong : {Eigen::Matrix3d(1.01 * Eigen::Matrix3d::Identity()),      // scaled
                                       Eigen::Matrix3d(Eigen::Vector3d(1, 1, -1).asDiagonal()),  // mirrored
                                       Eigen::Matrix3d(Eigen::Matrix3d::Zero())}) {
    Scene scene = wall(2);
    scene.rig.cameras[0].name = "bent";
    scene.rig.cameras[0].T_world_camera.linear() = wrong;
    expectRefused(scene, {"bent", "T_world_camera", "not rigid"});
  }
  Scene scene = wall(2);
  scene.rig.cameras[0].T_world_camera.translation().x() = std::numeric_limits<double>::infinity();
  expectRefused(scene, {"T_world_camera", "finite"});
}

TEST(FuseFlowBadInput, AnImageThatDoesNotFitItsCameraIsRefusedWithBothSizes) {
  Scene scene = wall(2);
  scene.rig.cameras[1].name = "cropped";
  scene.depth[1] = scenes::uniform(95, 72, 1.5f);
  scene.attach();
  expectRefused(scene, {"cropped", "depth", "95x72", "96x72"});

  Scene colored = wall(2);
  colored.paint({1, 2, 3});
  colored.color[0].resize(96, 71);
  colored.attach();
  expectRefused(colored, {"color", "96x71", "96x72"});
}

TEST(FuseFlowBadInput, RowsThatOverlapTwoKindsOfDepthAndAScaleOfZeroAreRefused) {
  Scene scene = wall(1);
  scene.rig.views[0].depth32.row_stride = 4 * 95;
  expectRefused(scene, {"row stride", "380"});

  scene.depth16.resize(1);
  scene.depth16[0].resize(96, 72);
  scene.attach();
  scene.rig.cameras[0].depth_scale = 0;
  expectRefused(scene, {"depth_scale is 0"});
  scene.rig.cameras[0].depth_scale = 0.001f;
  scene.rig.views[0].depth32 = scene.depth[0].view();
  expectRefused(scene, {"depth16", "depth32"});
}

TEST(FuseFlowBadInput, AFrameWithoutAnyViewGivesAnEmptyCloudAndNamesAllCameras) {
  Scene scene = wall(3);
  scene.rig.views.assign(3, {});
  scene.rig.stamp = 42;
  FuseFlow<PointFused> fusion;
  Cloud cloud(5, 1);  // what was in the output goes
  fusion.fuse(scene.rig, cloud);
  EXPECT_TRUE(cloud.empty());
  EXPECT_EQ(cloud.width, 0u);
  EXPECT_EQ(cloud.header.stamp, 42u);
  EXPECT_EQ(fusion.getStatistics().missing_cameras, (std::vector<std::size_t>{0, 1, 2}));
  EXPECT_EQ(fusion.getStatistics().measured_points, 0u);
}

TEST(FuseFlowBadInput, AMissingCameraIsNamedAndTheOthersFuseAsIfItWereNotThere) {
  Scene scene = wall(3);
  scene.rig.views[1] = {};
  FrameStatistics statistics;
  const Cloud cloud = scenes::fuse(scene.rig, {}, 2, &statistics);
  EXPECT_EQ(statistics.missing_cameras, std::vector<std::size_t>{1});

  scene.rig.views.erase(scene.rig.views.begin() + 1);
  scene.rig.cameras.erase(scene.rig.cameras.begin() + 1);
  const Cloud without = scenes::fuse(scene.rig);
  EXPECT_FALSE(without.empty());
  EXPECT_EQ(scenes::bytes(cloud), scenes::bytes(without));
}

TEST(FuseFlowBadInput, DepthOfZeroEverywhereGivesAnEmptyCloudAndIsNotAMissingCamera) {
  const Scene scene = scenes::makeFlatScene(scenes::cameraRow(2), {0.0f, 0.0f});
  FrameStatistics statistics;
  EXPECT_TRUE(scenes::fuse(scene.rig, {}, 2, &statistics).empty());
  EXPECT_TRUE(statistics.missing_cameras.empty());
  EXPECT_EQ(statistics.measured_points, 0u);
}

TEST(FuseFlowBadInput, NotANumberInfinityAndNegativeDepthAreNoMeasurements) {
  Scene scene = wall(2);
  const float bad[] = {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                       -std::numeric_limits<float>::infinity(), -1.5f};
  for (int k = 0; k < 4; ++k)
    for (scenes::Scene* s : {&scene}) s->depth[0].at(20 + 10 * k, 30) = bad[k];
  FrameStatistics statistics;
  const Cloud cloud = scenes::fuse(scene.rig, {}, 2, &statistics);
  EXPECT_EQ(statistics.measured_points, 2u * 96u * 72u - 4u);
  for (const auto& point : cloud) ASSERT_NEAR(point.z, 1.5f, 1e-5f);

  for (int k = 0; k < 4; ++k) scene.depth[0].at(20 + 10 * k, 30) = 0;
  EXPECT_EQ(scenes::bytes(cloud), scenes::bytes(scenes::fuse(scene.rig)));
}

TEST(FuseFlowBadInput, IntegerDepthOf65535IsNoMeasurement) {
  Scene scene = wall(1);
  scene.depth16.resize(1);
  scene.depth16[0].resize(96, 72);
  std::fill(scene.depth16[0].data.begin(), scene.depth16[0].data.end(), std::uint16_t{60000});
  scene.depth16[0].at(40, 40) = 65535;
  scene.attach();
  scene.rig.cameras[0].depth_scale = 0.0001f;  // 65535 would be 6.55 m, well in range
  FrameStatistics statistics;
  const Cloud cloud = scenes::fuse(scene.rig, {}, 2, &statistics);
  EXPECT_EQ(statistics.measured_points, 96u * 72u - 1u);
  for (const auto& point : cloud) {
    const double z = (scene.rig.cameras[0].T_world_camera.inverse() * point.getVector3fMap().cast<double>()).z();
    ASSERT_NEAR(z, 6.0, 1e-4);
  }
}

TEST(FuseFlowBadInput, OneCameraAloneIsNotContradicted) {
  FuseFlowParameters parameters;
  parameters.half_weight_noise = 0;
  const Cloud cloud = scenes::fuse(wall(1).rig, parameters);
  ASSERT_FALSE(cloud.empty());
  std::size_t certain = 0;
  for (const auto& point : cloud) {
    ASSERT_EQ(point.view_count, 1u);
    certain += point.confidence > 0.999f ? 1 : 0;  // C = 1 inside the image and V = 1
  }
  EXPECT_GT(certain, cloud.size() * 9 / 10);
}

TEST(FuseFlowBadInput, ARigWithFewerOtherCamerasThanMustAgreeIsRefused) {
  FuseFlowParameters parameters;
  parameters.agreement.min_views = 2;
  const Scene two = scenes::wall(2);
  expectMentions(messageOf([&] { scenes::fuse(two.rig, parameters); }),
                 {"FuseFlow", "agreement.min_views is 2", "1 other"});
  EXPECT_NO_THROW(scenes::fuse(scenes::wall(3).rig, parameters));
}

TEST(FuseFlowBadInput, TwoIdenticalCamerasAgreeCompletely) {
  const Scene scene = scenes::makeScene(scenes::sameCameras(2, 96, 72, 90), scenes::plane({0, 0, 1}, 1.5));
  const Cloud cloud = scenes::fuse(scene.rig);
  ASSERT_FALSE(cloud.empty());
  for (const auto& point : cloud) {
    ASSERT_EQ(point.view_count, 2u);
    ASSERT_NEAR(point.z, 1.5f, 1e-5f);
  }
}

TEST(FuseFlowBadInput, SixtyFourCamerasFuse) {
  std::vector<fuse_flow::Camera> cameras;
  for (int i = 0; i < 64; ++i)
    cameras.push_back(scenes::lookAt({0.1 * (i % 8) - 0.35, 0.1 * (i / 8) - 0.35, 0}, {0, 0, 1.5}, 12, 8, 20));
  const Scene scene = scenes::makeScene(cameras, scenes::plane({0, 0, 1}, 1.5));
  FrameStatistics statistics;
  const Cloud cloud = scenes::fuse(scene.rig, {}, 2, &statistics);
  EXPECT_EQ(statistics.measured_points, 64u * 12u * 8u);
  ASSERT_FALSE(cloud.empty());
  for (const auto& point : cloud) {
    ASSERT_NEAR(point.z, 1.5f, 1e-5f);
    ASSERT_GE(point.view_count, 1u);
    ASSERT_LE(point.view_count, 64u);
  }
}

TEST(FuseFlowBadInput, APointTooFarForTheLatticeIsAnExceptionAndTheNextFrameFuses) {
  Scene scene = wall(2);
  FuseFlow<PointFused> fusion;
  Cloud cloud, expected = scenes::fuse(scene.rig);
  for (const unsigned int threads : {1u, 2u}) {
    fusion.setNumberOfThreads(threads);
    const Eigen::Isometry3d pose = scene.rig.cameras[1].T_world_camera;
    scene.rig.cameras[1].T_world_camera.translation().x() = 1e7;
    expectMentions(messageOf<pcl::PCLException>([&] { fusion.fuse(scene.rig, cloud); }), {"from the origin", "cells"});
    scene.rig.cameras[1].T_world_camera = pose;
    fusion.fuse(scene.rig, cloud);
    EXPECT_EQ(scenes::bytes(cloud), scenes::bytes(expected));
  }
}

TEST(FuseFlowBadInput, FramesMayChangeTheirSizeAndTheirNumberOfCameras) {
  const Scene small = scenes::makeScene(scenes::cameraRow(2, 40, 30, 40), scenes::ballAndWall());
  const Scene large = scenes::makeScene(scenes::cameraRow(5, 120, 90, 110), scenes::ballAndWall());
  const Scene other = scenes::makeScene(scenes::cameraRow(3), scenes::ballAndWall());
  FuseFlow<PointFused> fusion;
  Cloud cloud;
  for (const Scene* scene : {&small, &large, &other, &small, &other, &large}) {
    fusion.fuse(scene->rig, cloud);
    EXPECT_EQ(scenes::bytes(cloud), scenes::bytes(scenes::fuse(scene->rig)));  // nothing of the last frame is left
  }
}

TEST(FuseFlowBadInput, AMovedCameraIsNoticed) {
  Scene scene = wall(2);
  FuseFlow<PointFused> fusion;
  Cloud cloud;
  fusion.fuse(scene.rig, cloud);
  for (fuse_flow::Camera& camera : scene.rig.cameras) camera.T_world_camera.pretranslate(Eigen::Vector3d(0, 0, 0.3));
  fusion.fuse(scene.rig, cloud);
  ASSERT_FALSE(cloud.empty());
  for (const auto& point : cloud) ASSERT_NEAR(point.z, 1.8f, 1e-5f);
}

/** \brief One parameter set to a value outside its range, and what the message must say. */
struct BadParameter {
  std::function<void(FuseFlowParameters&)> set;
  std::vector<std::string> message;
};

TEST(FuseFlowBadInput, AParameterOutOfItsRangeIsRefusedByClassNameAndValueAndChangesNothing) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<BadParameter> all{
      {[](auto& p) { p.preprocessing.min_range = -1; }, {"DepthBackprojection", "min_range", "-1"}},
      {[](auto& p) { p.preprocessing.max_range = 0; }, {"DepthBackprojection", "max_range", "0"}},
      {[](auto& p) { p.preprocessing.min_range = 30; }, {"DepthBackprojection", "max_range is 20", "min_range, 30"}},
      {[](auto& p) { p.preprocessing.max_range = std::numeric_limits<float>::infinity(); },
       {"DepthBackprojection", "max_range", "inf"}},
      {[](auto& p) { p.preprocessing.fill_neighbours = 9; }, {"DepthBackprojection", "fill_neighbours", "9"}},
      {[](auto& p) { p.preprocessing.fill_neighbours = 2; }, {"DepthBackprojection", "fill_neighbours", "2"}},
      {[](auto& p) { p.preprocessing.bilateral_sigma_r = 0; }, {"DepthBackprojection", "bilateral_sigma_r", "0"}},
      {[](auto& p) { p.confidence.alpha = -0.5f; }, {"ConfidenceEstimation", "alpha", "-0.5"}},
      {[](auto& p) { p.confidence.alpha = p.confidence.gamma = 0; }, {"ConfidenceEstimation", "alpha + gamma", "0"}},
      {[](auto& p) { p.confidence.threshold = 1.5f; }, {"ConfidenceEstimation", "threshold", "1.5"}},
      {[](auto& p) { p.confidence.length_unit = 0; }, {"ConfidenceEstimation", "length_unit", "0"}},
      {[](auto& p) { p.confidence.max_incidence = 2; }, {"ConfidenceEstimation", "max_incidence", "2"}},
      {[=](auto& p) { p.consistency.sigma = nan; }, {"MultiViewConsistency", "sigma", "nan"}},
      {[](auto& p) { p.consistency.margin = 0; }, {"MultiViewConsistency", "margin", "0"}},
      {[](auto& p) { p.consistency.free_space_penalty = 1.25f; },
       {"MultiViewConsistency", "free_space_penalty", "1.25"}},
      {[](auto& p) { p.consistency.min_facing = -1.25f; }, {"MultiViewConsistency", "min_facing", "-1.25"}},
      {[](auto& p) { p.consistency.silhouette_radius = 9; }, {"MultiViewConsistency", "silhouette_radius", "9"}},
      {[](auto& p) { p.consistency.max_views = 1; }, {"MultiViewConsistency", "max_views", "1"}},
      {[](auto& p) { p.consistency.max_candidates = 6; }, {"MultiViewConsistency", "max_candidates", "6"}},
      {[](auto& p) { p.aggregation.cell_size = 0; }, {"AdaptiveHashFusion", "cell_size", "0"}},
      {[](auto& p) { p.aggregation.min_cell_size = -0.01f; }, {"AdaptiveHashFusion", "min_cell_size", "-0.01"}},
      {[](auto& p) { p.aggregation.cell_size = 3e38f; },
       {"AdaptiveHashFusion", "cell_size", "3e+38 m", "10 m or less"}},
      {[](auto& p) { p.aggregation.min_cell_size = 30; },
       {"AdaptiveHashFusion", "min_cell_size is 30 m", "1 m or less", "30 mm are 0.03 m"}},
      {[](auto& p) { p.aggregation.confirmation_reach = 25; },
       {"AdaptiveHashFusion", "confirmation_reach is 25 m", "25 mm are 0.025 m"}},
      {[](auto& p) { p.consistency.sigma = 20; }, {"MultiViewConsistency", "sigma is 20 m", "20 mm are 0.02 m"}},
      {[](auto& p) { p.preprocessing.fill_tolerance = 20; }, {"DepthBackprojection", "fill_tolerance is 20 m"}},
      {[](auto& p) { p.preprocessing.bilateral_sigma_r = 30; }, {"DepthBackprojection", "bilateral_sigma_r is 30 m"}},
      {[](auto& p) { p.confidence.noise.floor = 20; }, {"ConfidenceEstimation", "noise.floor is 20 m"}},
      {[](auto& p) { p.confidence.noise_reference = 1e4f; }, {"ConfidenceEstimation", "noise_reference is 10000 m"}},
      {[](auto& p) { p.half_weight_noise = 25; }, {"FuseFlow", "half_weight_noise is 25 m"}},
      {[](auto& p) { p.gate_noise = 20; }, {"FuseFlow", "gate_noise is 20 m", "20 mm are 0.02 m"}},
      {[=](auto& p) { p.gate_noise = nan; }, {"FuseFlow", "gate_noise", "nan"}},
      {[](auto& p) { p.max_noise = 70; }, {"FuseFlow", "max_noise is 70 m", "70 mm are 0.07 m"}},
      {[](auto& p) { p.aggregation.points_per_cell = 0; }, {"AdaptiveHashFusion", "points_per_cell", "0"}},
      {[](auto& p) { p.smoothing.passes = 5; }, {"FuseFlow", "smoothing_passes", "5"}},
      {[](auto& p) { p.smoothing.passes = -1; }, {"FuseFlow", "smoothing_passes", "-1"}},
      {[=](auto& p) { p.smoothing.tolerance = nan; }, {"FuseFlow", "smoothing_tolerance", "nan"}},
      {[](auto& p) { p.smoothing.shrink = 1.5f; }, {"FuseFlow", "smoothing_shrink", "1.5"}},
      {[](auto& p) { p.smoothing.shrink = 0; }, {"FuseFlow", "smoothing_shrink", "0"}},
      {[](auto& p) { p.smoothing.wide_above = -1; }, {"FuseFlow", "smoothing_wide_above", "-1"}},
      {[](auto& p) { p.smoothing.twicing_above = -1; }, {"FuseFlow", "smoothing_twicing_above", "-1"}},
      {[](auto& p) { p.min_confidence = 1.5f; }, {"FuseFlow", "min_confidence is 1.5"}},
      {[](auto& p) { p.half_weight_noise = -1; }, {"FuseFlow", "half_weight_noise", "-1"}},
      {[=](auto& p) { p.max_noise = nan; }, {"FuseFlow", "max_noise", "nan"}},
      {[](auto& p) { p.min_support = 9; }, {"FuseFlow", "min_support", "9"}},
      {[](auto& p) { p.min_support = -1; }, {"FuseFlow", "min_support", "-1"}},
      {[](auto& p) { p.agreement.min_views = -1; }, {"FuseFlow", "agreement.min_views", "-1"}},
      {[](auto& p) { p.agreement.min_views = 64; }, {"FuseFlow", "agreement.min_views", "64"}},
      {[](auto& p) { p.agreement.pixels = 0; }, {"FuseFlow", "agreement.pixels", "0"}},
      {[](auto& p) { p.agreement.relative = 0; }, {"FuseFlow", "agreement.relative", "0"}},
      {[](auto& p) { p.agreement.relative = 1.5f; }, {"FuseFlow", "agreement.relative", "1.5"}},
      {[](auto& p) { p.aggregation.min_weight = 2; }, {"AdaptiveHashFusion", "min_weight", "2"}},
      {[=](auto& p) { p.aggregation.weak_weight = nan; }, {"AdaptiveHashFusion", "weak_weight", "nan"}},
      {[](auto& p) { p.aggregation.confirmation_reach = -1; }, {"AdaptiveHashFusion", "confirmation_reach", "-1"}},
      {[=](auto& p) { p.aggregation.reach_per_noise = nan; }, {"AdaptiveHashFusion", "reach_per_noise", "nan"}},
      {[](auto& p) { p.crop_box = Eigen::AlignedBox3f(); }, {"FuseFlow", "crop_box"}}};
  FuseFlow<PointFused> fusion;
  for (const BadParameter& bad : all) {
    FuseFlowParameters parameters;
    parameters.confidence.beta = 0.75f;  // so that a setter that keeps half of them is caught
    bad.set(parameters);
    expectMentions(messageOf([&] { fusion.setParameters(parameters); }), bad.message);
    EXPECT_EQ(fusion.getParameters().confidence.beta, FuseFlowParameters().confidence.beta);
  }
}

}  // namespace
