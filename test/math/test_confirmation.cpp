#include "../scenes.h"

#include <fuse_flow/impl/fusion/cell_confirmations.hpp>
#include <fuse_flow/math/confirmation.h>

namespace {

using fuse_flow::Confirmation;
using fuse_flow::depthBetween;
using fuse_flow::FuseFlowParameters;
using fuse_flow::Vec3;
using scenes::Cloud;
using scenes::Scene;

// ---- Between pixels

/** \brief 1/z = 0.5 + 0.01 u − 0.02 v around pixel (3, 4), 1/metres. */
double slanted(double u, double v) { return 1 / (0.5 + 0.01 * u - 0.02 * v); }

TEST(DepthBetween, IsThatOfASlantedPlaneExactly) {
  const auto at = [](int a, int b) { return static_cast<float>(slanted(3 + a, 4 + b)); };
  for (const float du : {-0.5f, -0.2f, 0.0f, 0.3f, 0.5f})
    for (const float dv : {-0.4f, 0.0f, 0.5f})
      EXPECT_NEAR(depthBetween(du, dv, 1.0f, at), slanted(3.0 + static_cast<double>(du), 4.0 + static_cast<double>(dv)),
                  1e-6);
}

TEST(DepthBetween, BesideAHoleOrAJumpTheOtherSideStandsIn) {
  for (const float there : {0.0f, 0.5f, 9.0f}) {
    const auto at = [there](int a, int b) {
      return a > 0 || b < 0 ? there : static_cast<float>(slanted(3 + a, 4 + b));
    };
    EXPECT_NEAR(depthBetween(0.3f, -0.4f, 0.3f, at), slanted(3.3, 3.6), 1e-6) << there;
  }
}

TEST(DepthBetween, IsNotKnownBetweenTwoHolesOrJumps) {
  for (const float there : {0.0f, 0.5f, 9.0f}) {
    EXPECT_EQ(depthBetween(0.3f, 0.0f, 0.3f, [there](int a, int) { return a ? there : 2.0f; }), 0.0f) << there;
    EXPECT_EQ(depthBetween(0.3f, 0.0f, 0.3f, [there](int, int b) { return b ? there : 2.0f; }), 0.0f) << there;
  }
}

// ---- The equation, by hand

constexpr float kReach = 0.03f;

/** \brief What a difference counts: a of Confirmation. */
constexpr double countsAs(double e, double reach) {
  const double square = e * e / (reach * reach), rest = 1 - square * square;
  return rest * rest;
}

/** \brief Of 6 mm in 30. */
constexpr double kA = countsAs(0.006, 0.03);

TEST(Confirmation, WithoutViewsThePointStays) {
  const Vec3 p = Confirmation().moved({1, 2, 3}, 0.5f);
  EXPECT_EQ(p.x, 1);
  EXPECT_EQ(p.y, 2);
  EXPECT_EQ(p.z, 3);
}

TEST(Confirmation, OneViewDrawsThePointAlongItsRay) {
  // 2 m before the view, 6 mm short of its depth: along (0.5, 0, 1) by 6 mm of depth, weighed with a/2 against ω = 0.7.
  Confirmation confirmation;
  confirmation.add({1, 0, 2}, Confirmation::share(2.0f, 2.006f, 0.5f, kReach * kReach));
  const double w = 0.5 * kA, dz = kA * w * 0.006 / (0.7 + w);
  const Vec3 p = confirmation.moved({0, 0, 0}, 0.7f);
  EXPECT_NEAR(p.x, 0.5 * dz, 1e-7);
  EXPECT_EQ(p.y, 0.0f);
  EXPECT_NEAR(p.z, dz, 1e-7);
}

TEST(Confirmation, ViewsOnBothSidesLeaveItInTheMiddle) {
  Confirmation confirmation;
  confirmation.add({0, 0, 1}, Confirmation::share(1.0f, 1.006f, 1.0f, kReach * kReach));
  confirmation.add({0, 0, 1}, Confirmation::share(1.0f, 0.994f, 1.0f, kReach * kReach));
  EXPECT_NEAR(confirmation.moved({0, 0, 0}, 1.0f).z, 0, 1e-7);
}

TEST(SameSurface, IsWhatDiffersByLessThanAJump) {
  EXPECT_TRUE(fuse_flow::isSameSurface(1, 1.1875f, 0.25f));
  EXPECT_TRUE(fuse_flow::isSameSurface(1, 0.8125f, 0.25f));
  EXPECT_FALSE(fuse_flow::isSameSurface(1, 1.25f, 0.25f));
  EXPECT_FALSE(fuse_flow::isSameSurface(1, 0.75f, 0.25f));
  EXPECT_FALSE(fuse_flow::isSameSurface(0.125f, 0, 0.25f)) << "a hole";
}

TEST(Confirmation, AViewThatMeasuredSomethingBeyondTheReachStopsTheOthers) {
  Confirmation confirmation;
  confirmation.add({0, 0, 1}, Confirmation::share(1.0f, 1.006f, 1.0f, kReach * kReach));
  EXPECT_GT(confirmation.moved({0, 0, 0}, 1.0f).z, 0.002f);
  confirmation.add({0, 0, 1}, Confirmation::share(1.0f, 1.031f, 1.0f, kReach * kReach));
  EXPECT_EQ(confirmation.moved({0, 0, 0}, 1.0f).z, 0.0f);
}

TEST(Confirmation, WhatLiesWellInsideTheReachCountsInFullAndWhatLiesBeyondNotAtAll) {
  const auto a = [](float e) { return Confirmation::share(1.0f, 1.0f + e, 1.0f, kReach * kReach).a; };
  EXPECT_GT(a(0.01f), 0.97f);
  EXPECT_NEAR(a(-0.02f), 0.644, 1e-3);  // (1 - 16/81)²
  EXPECT_LT(a(0.028f), 0.1f);
  EXPECT_EQ(a(0.0301f), 0.0f);
}

TEST(Confirmation, TheReachIsNoLessThanWhatNoiseScatters) {
  const auto reach = [](float per_noise, float variance) {
    return std::sqrt(Confirmation::squaredReach(0.03f, per_noise, variance));
  };
  EXPECT_NEAR(reach(2.0f, 0.0001f), 0.03f, 1e-8);
  EXPECT_NEAR(reach(2.0f, 0.0004f), 0.04f, 1e-8);
  EXPECT_NEAR(reach(0.0f, 0.0004f), 0.03f, 1e-8);
  EXPECT_NEAR(reach(2.0f, 0.01f), 0.06f, 1e-8);  // not without end
  EXPECT_NEAR(Confirmation::varianceOf(0.003f, 0.001f, 2.0f), 0.005f * 0.005f, 1e-9);
}

TEST(Confirmation, ThePointMovesByLessThanHalfOfTheReach) {
  for (const float e : {0.001f, 0.005f, 0.01f, 0.0173f, 0.02f, 0.029f, -0.012f})
    for (const float weight : {0.001f, 1.0f}) {
      Confirmation confirmation;
      for (int view = 0; view < 7; ++view)
        confirmation.add({0, 0, 1.5f}, Confirmation::share(1.5f, 1.5f + e, 1.0f, kReach * kReach));
      const float dz = confirmation.moved({0, 0, 0}, weight).z;
      EXPECT_LE(std::abs(dz), 0.46f * kReach);
      EXPECT_LE(std::abs(dz), std::abs(e));
      EXPECT_GE(dz * e, 0.0f);
    }
}

TEST(Confirmation, AViewWithoutDepthThereChangesNothing) {
  Confirmation confirmation;
  confirmation.add({0, 0, 1}, Confirmation::share(1.0f, 1.006f, 1.0f, kReach * kReach));
  const float z = confirmation.moved({0, 0, 0}, 1.0f).z;
  for (const float none : {0.0f, std::nanf("")}) {
    confirmation.add({0, 0, 1}, Confirmation::share(1.0f, none, 1.0f, kReach * kReach));
    EXPECT_EQ(confirmation.moved({0, 0, 0}, 1.0f).z, z);
  }
}

TEST(CellConfirmations, TheReachGrowsWithTheNoiseThatAViewWasMeasuredToHave) {
  fuse_flow::host::DepthMap refined;
  refined.resize(3, 3);
  for (int v = 0; v < 3; ++v) std::fill_n(refined.row(v), 3, 2.03f);
  fuse_flow::host::CellConfirmations confirmations;
  confirmations.reserve(3);
  const fuse_flow::NoiseModel noise{0, 0, 0.01f / (2.03f * 2.03f)};
  for (const float noise_scale : {1.0f, 2.0f}) confirmations.add(refined, 1.5f, 1.5f, 2.0f, {noise, noise_scale, 1}, 0);
  confirmations.add(refined, 1.5f, 1.5f, 2.0f, {noise, 1, 1}, 0.02f / (2.03f * 2.03f));
  confirmations.weigh({0.025f, 2.0f, 1 / 0.02f});
  EXPECT_EQ(confirmations[0].a, 0.0f);  // 30 mm away, with a reach of 25
  const double a = countsAs(0.03, 0.04);
  EXPECT_NEAR(confirmations[1].a, a, 1e-4);
  EXPECT_NEAR(confirmations[1].w, a / 2, 1e-4);  // noise of 20 mm halves the weight
  EXPECT_NEAR(confirmations[2].a, countsAs(0.03, 2 * std::hypot(0.01, 0.02)), 1e-4);
  EXPECT_NEAR(confirmations[2].w, confirmations[2].a / 1.25f, 1e-4);  // multipath does not
}

// ---- In the pipeline

/** \brief Two cameras of one pose see a wall 6 mm apart, in different cells of 8 mm. Every weight is 1. */
Scene wallTwice() { return scenes::makeFlatScene(scenes::sameCameras(2, 40, 40, 90), {1.004f, 1.010f}); }

FuseFlowParameters equalWeights() {
  FuseFlowParameters parameters;
  parameters.use_measurement_confidence = false;
  parameters.half_weight_noise = 0;
  parameters.adapt_noise = false;
  parameters.aggregation.confirmation_reach = kReach;
  return parameters;
}

/** \brief Of the nearer and of the farther half, all of which must lie at one depth each. */
void expectDepths(const Cloud& cloud, double nearer, double farther) {
  std::array<std::size_t, 2> count{};
  for (const auto& point : cloud) {
    const std::size_t side = static_cast<double>(point.z) > (nearer + farther) / 2 ? 1 : 0;
    ++count[side];
    ASSERT_NEAR(point.z, side ? farther : nearer, 2e-6);
  }
  EXPECT_GT(count[0], 500u);
  EXPECT_GT(count[1], 500u);
}

TEST(FuseFlowConfirmation, TwoViewsOfOneWallComeNearerToEachOther) {
  const double move = kA * kA * 0.006 / (1 + kA);
  expectDepths(scenes::fuse(wallTwice().rig, equalWeights()), 1.004 + move, 1.010 - move);
}

TEST(FuseFlowConfirmation, NoisyViewsReachFarther) {
  // 16 mm apart, which count 0.84 with a reach of 30 mm, and 0.95 with 40.
  const Scene scene = scenes::makeFlatScene(scenes::sameCameras(2, 40, 40, 90), {1.004f, 1.020f});
  FuseFlowParameters parameters = equalWeights();
  parameters.confidence.noise.floor = 0.02f;
  parameters.confidence.noise.quadratic = 0;
  for (const float per_noise : {0.0f, 1.0f, 1.75f, 2.0f}) {
    parameters.aggregation.reach_per_noise = per_noise;
    const double a = countsAs(0.016, std::max(0.03, 0.02 * static_cast<double>(per_noise)));
    const double move = a * a * 0.016 / (1 + a);
    expectDepths(scenes::fuse(scene.rig, parameters), 1.004 + move, 1.020 - move);
  }
}

TEST(FuseFlowConfirmation, TheReachIsThatOfTheViewThatConfirms) {
  // Multipath interference may leave 25 mm at 1 m in the farther camera: it confirms the nearer one's points within 1.6 times that.
  auto cameras = scenes::sameCameras(2, 40, 40, 90);
  cameras[1].multipath.modulation_frequency = 20e6f;
  const Scene scene = scenes::makeFlatScene(cameras, {1.004f, 1.020f});
  FuseFlowParameters parameters = equalWeights();
  parameters.confidence.noise.floor = 1e-4f;
  parameters.confidence.noise.quadratic = 0;
  parameters.aggregation.reach_per_noise = 1.6f;
  const double period = 299792458.0 / 40e6, pi = 3.14159265358979;
  const double late = 0.035 * static_cast<double>(cameras[1].multipath.reflectance) * period / (2 * pi) * 1.02 * 1.02;
  const double near = countsAs(0.016, 1.6 * late), far = countsAs(0.016, 0.03);
  ASSERT_GT(1.6 * late, 0.035);
  ASSERT_LT(1.6 * late, 0.06);
  expectDepths(scenes::fuse(scene.rig, parameters), 1.004 + near * near * 0.016 / (1 + near),
               1.020 - far * far * 0.016 / (1 + far));
}

TEST(FuseFlowConfirmation, TheFourNearestViewsHaveASay) {
  // The fifth, of one place with the others and so the last that is asked, sees the wall 16 mm away.
  const Scene scene =
      scenes::makeFlatScene(scenes::sameCameras(6, 40, 40, 90), {1.004f, 1.010f, 1.010f, 1.010f, 1.010f, 1.020f});
  FuseFlowParameters parameters = equalWeights();
  parameters.aggregation.confirmation_reach = 0.012f;
  const double a = countsAs(0.006, 0.012);
  std::size_t count = 0;
  for (const auto& point : scenes::fuse(scene.rig, parameters)) {
    if (point.z > 1.0086f) continue;
    ++count;
    ASSERT_NEAR(point.z, 1.004 + a * 4 * a * 0.006 / (1 + 4 * a), 2e-6);
  }
  EXPECT_GT(count, 500u);
}

TEST(FuseFlowConfirmation, OffOrWithoutRefinedDepthPointsStayWhereTheirOwnMeasurementsAre) {
  for (int k = 0; k < 4; ++k) {
    FuseFlowParameters parameters = equalWeights();
    parameters.aggregation.reach_per_noise = 10;
    if (k == 0) parameters.aggregation.confirmation_reach = 0;
    if (k == 1) parameters.smoothing.passes = 0;
    if (k == 2) parameters.aggregation.consistency_at = fuse_flow::ConsistencyAt::Representatives;
    if (k == 3) parameters.use_distance_consistency = false;
    expectDepths(scenes::fuse(wallTwice().rig, parameters), 1.004, 1.010);
  }
}

TEST(FuseFlowConfirmation, APlaneAtAnyAngleStaysExactlyWhereItIs) {
  const Eigen::Vector3d n = Eigen::Vector3d(0.5, -0.3, 1).normalized();
  FuseFlowParameters parameters;
  const Cloud cloud = scenes::fuse(scenes::makeScene(scenes::cameraRow(4), scenes::plane(n, 1.3)).rig, parameters);
  ASSERT_GT(cloud.size(), 1000u);
  for (const auto& point : cloud) ASSERT_NEAR(n.dot(point.getVector3fMap().cast<double>()), 1.3, 5e-6);
}

TEST(FuseFlowConfirmation, OnlyPositionsChangeAndByLessThanTheReach) {
  Scene scene = scenes::makeScene(scenes::cameraRow(4, 160, 120, 150), scenes::ballAndWall());
  scenes::addNoise(scene, 0.004f);
  FuseFlowParameters parameters;
  parameters.aggregation.confirmation_reach = kReach;
  parameters.aggregation.reach_per_noise = 0;
  const Cloud cloud = scenes::fuse(scene.rig, parameters);
  parameters.aggregation.confirmation_reach = 0;
  const Cloud before = scenes::fuse(scene.rig, parameters);
  ASSERT_EQ(cloud.size(), before.size());
  constexpr float longest_ray = 1.202f;  // to the images' corners, over its depth
  std::size_t moved = 0;
  for (std::size_t k = 0; k < cloud.size(); ++k) {
    const float distance = (cloud[k].getVector3fMap() - before[k].getVector3fMap()).norm();
    ASSERT_LT(distance, 0.46f * kReach * longest_ray);
    ASSERT_EQ(cloud[k].confidence, before[k].confidence);
    ASSERT_EQ(cloud[k].view_count, before[k].view_count);
    moved += distance > 1e-4f ? 1 : 0;
  }
  EXPECT_GT(moved, cloud.size() / 4);
}

TEST(FuseFlowConfirmation, BringsANoisyWallNearerToTheTruth) {
  Scene scene = scenes::makeScene(scenes::cameraRow(4, 160, 120, 150), scenes::plane({0.1, 0.2, 1}, 1.5));
  scenes::addNoise(scene, 0.006f);
  FuseFlowParameters parameters;
  const auto error = [&] {
    double sum = 0;
    const Cloud cloud = scenes::fuse(scene.rig, parameters);
    for (const auto& p : cloud)
      sum += std::abs(Eigen::Vector3d(0.1, 0.2, 1).dot(p.getVector3fMap().cast<double>()) - 1.5);
    return sum / static_cast<double>(cloud.size());
  };
  const double with = error();
  parameters.aggregation.confirmation_reach = 0;
  EXPECT_LT(with, 0.85 * error());
}

}  // namespace
