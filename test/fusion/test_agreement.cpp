#include "../scenes.h"

#include <fuse_flow/math/agreement.h>

#include <cmath>

namespace {

using fuse_flow::AgreementParameters;
using fuse_flow::FrameStatistics;
using fuse_flow::FuseFlowParameters;
using fuse_flow::Vec3;
using fuse_flow::ViewModel;
using scenes::Cloud;
using scenes::Scene;
using scenes::Vector3d;

/** \brief A camera along z with its centre at (x, 0, 0). */
ViewModel modelAt(float x) {
  fuse_flow::Camera camera = scenes::sameCameras(1, 101, 101, 100)[0];
  camera.T_world_camera.translation().x() = static_cast<double>(x);
  fuse_flow::host::ViewGeometry view;
  view.assign(camera, true);
  return view;
}

TEST(Agreement, ThereAndBackByHand) {
  const ViewModel view = modelAt(0), other = modelAt(0.5f);
  // The point (0, 0, 2) of pixel (50, 50). The other view, half a metre to the right, has it at 2 m too.
  const auto agrees = [&](float measured, float pixels, float relative) {
    return agreesThereAndBack({1, pixels, relative}, view, {50, 50}, 2, {0, 0, 2}, other, 2, measured);
  };
  EXPECT_TRUE(agrees(2, 1e-3f, 1e-4f));
  // At 2.02 m on its ray lies (−0.005, 0, 2.02): −0.2475 pixels, 1 % farther.
  EXPECT_TRUE(agrees(2.02f, 0.249f, 0.0101f));
  EXPECT_FALSE(agrees(2.02f, 0.246f, 0.0101f));
  EXPECT_FALSE(agrees(2.02f, 0.249f, 0.0099f));
  EXPECT_TRUE(agrees(1.98f, 0.254f, 0.0101f));  // 0.2525 pixels the other way
  EXPECT_FALSE(agrees(1.98f, 0.251f, 0.0101f));
  // At 2.5 m on its ray: (−0.125, 0, 2.5), 5 pixels and a quarter of the depth, exactly.
  EXPECT_TRUE(agrees(2.5f, 5, 0.25f));
  EXPECT_FALSE(agrees(2.5f, std::nextafter(5.0f, 0.0f), 0.25f));
  EXPECT_FALSE(agrees(2.5f, 5, std::nextafter(0.25f, 0.0f)));
  EXPECT_FALSE(agrees(0, 1000, 1));  // nothing measured agrees with nothing
  EXPECT_FALSE(agrees(NAN, 1000, 1));
}

/** \brief Only the agreement of views decides what becomes a point, and each pixel becomes one. */
FuseFlowParameters agreementAlone(int min_views) {
  FuseFlowParameters p;
  p.use_measurement_confidence = p.use_distance_consistency = p.use_spatial_hash = p.adapt_noise = false;
  p.smoothing.passes = 0;
  p.agreement.min_views = min_views;
  return p;
}

std::size_t pointsOf(const std::vector<float>& depths, int min_views) {
  const int n = static_cast<int>(depths.size());
  return scenes::fuse(scenes::makeFlatScene(scenes::sameCameras(n, 60, 40, 50), depths).rig, agreementAlone(min_views))
             .size() /
         (60 * 40);
}

TEST(Agreement, CountsOtherViewsThatMeasureTheSame) {
  EXPECT_EQ(pointsOf({2, 2, 3}, 0), 3u);
  EXPECT_EQ(pointsOf({2, 2, 3}, 1), 2u);
  EXPECT_EQ(pointsOf({2, 2, 3}, 2), 0u);
  EXPECT_EQ(pointsOf({2, 3, 2, 3, 2}, 1), 5u);
  EXPECT_EQ(pointsOf({2, 3, 2, 3, 2}, 2), 3u);
  EXPECT_EQ(pointsOf({2, 3, 2, 3, 2}, 3), 0u);
  EXPECT_EQ(pointsOf({2, 2.01f, 2.05f}, 1), 2u);  // 0.5 and 2 % apart
  EXPECT_EQ(pointsOf({2, 0, 2}, 1), 2u);
  EXPECT_EQ(pointsOf({2, 0, 0}, 1), 0u);
}

TEST(Agreement, AMissingCameraAgreesWithNothingNotEvenWithWhatItMeasuredBefore) {
  Scene scene = scenes::makeFlatScene(scenes::sameCameras(3, 60, 40, 50), {2, 2, 2});
  EXPECT_EQ(scenes::fuse(scene.rig, agreementAlone(2)).size(), 3u * 60 * 40);
  FuseFlowParameters smoothed = agreementAlone(2);
  smoothed.smoothing.passes = 3;
  fuse_flow::FuseFlow<fuse_flow::PointFused> fusion;
  fusion.setParameters(smoothed);
  Cloud cloud;
  fusion.fuse(scene.rig, cloud);
  EXPECT_EQ(cloud.size(), 3u * 60 * 40);
  scene.rig.views[0] = {};
  fusion.fuse(scene.rig, cloud);
  EXPECT_TRUE(cloud.empty());
  EXPECT_EQ(scenes::fuse(scene.rig, agreementAlone(1)).size(), 2u * 60 * 40);
  EXPECT_TRUE(scenes::fuse(scene.rig, agreementAlone(2)).empty());
}

TEST(Agreement, WhatHasNoConfidenceAtAllAgreesWithNothing) {
  Scene scene = scenes::makeFlatScene(scenes::sameCameras(3, 60, 40, 50), {2, 2, 2});
  const auto points = [&](float third) {
    scene.confidence = {scenes::uniform(60, 40, 1), scenes::uniform(60, 40, 1), scenes::uniform(60, 40, third)};
    scene.attach();
    return scenes::fuse(scene.rig, agreementAlone(2)).size() / (60 * 40);
  };
  EXPECT_EQ(points(1), 3u);
  EXPECT_EQ(points(0.1f), 2u);  // dropped by min_confidence, but it agrees
  EXPECT_EQ(points(0), 0u);
  EXPECT_EQ(points(NAN), 0u);
}

/** \brief In double precision, with matrices: how many other views measure the same; −1: it is close to the limits. */
int agreeing(const Scene& scene, const AgreementParameters& p, std::size_t i, int u, int v) {
  const auto K = [&](std::size_t k) {
    const fuse_flow::Intrinsics& k_ = scene.rig.cameras[k].intrinsics;
    Eigen::Matrix3d matrix;
    matrix << static_cast<double>(k_.fx), 0, static_cast<double>(k_.cx), 0, static_cast<double>(k_.fy),
        static_cast<double>(k_.cy), 0, 0, 1;
    return matrix;
  };
  const auto T = [&](std::size_t k) { return scene.rig.cameras[k].T_world_camera; };
  const auto z = static_cast<double>(scene.depth[i].at(u, v));
  const Vector3d p_W = T(i) * (z * K(i).inverse() * Vector3d(u, v, 1));
  int count = 0;
  for (std::size_t j = 0; j < scene.depth.size(); ++j) {
    if (j == i) continue;
    const Vector3d in_j = K(j) * (T(j).inverse() * p_W);
    if (in_j.z() <= 0) continue;
    const Vector3d at = in_j / in_j.z();
    const double x = at.x() + 0.5, y = at.y() + 0.5;
    if (std::abs(x - std::round(x)) < 1e-3 || std::abs(y - std::round(y)) < 1e-3) return -1;
    if (x < 0 || y < 0 || x >= scene.depth[j].width || y >= scene.depth[j].height) continue;
    const auto D = static_cast<double>(scene.depth[j].at(static_cast<int>(x), static_cast<int>(y)));
    if (!(D > 0)) continue;
    const Vector3d back = T(i).inverse() * (T(j) * (D * K(j).inverse() * at));
    const Vector3d pixel = K(i) * back / back.z();
    const double off = std::hypot(pixel.x() - u, pixel.y() - v), apart = std::abs(back.z() - z) / z;
    if (std::abs(off - static_cast<double>(p.pixels)) < 1e-3 ||
        std::abs(apart - static_cast<double>(p.relative)) < 1e-5)
      return -1;
    count += off < static_cast<double>(p.pixels) && apart < static_cast<double>(p.relative) ? 1 : 0;
  }
  return count;
}

TEST(Agreement, LooksThroughLensesThereAndBack) {
  // A wall at 2 m, which every pixel of both cameras measures at 2 m, whatever its lens: all pixels agree whose points the other
  // image shows.
  std::vector<fuse_flow::Camera> cameras = scenes::sameCameras(2, 60, 40, 50);
  cameras[1].T_world_camera.translation().x() = 0.3;
  for (fuse_flow::Camera& camera : cameras) camera.intrinsics.distortion = {-0.25f, 0.05f, 0.002f, -0.003f};
  std::size_t expected = 0;
  for (int v = 0; v < 40; ++v)
    for (int u = 0; u < 60; ++u)
      for (const float baseline : {-0.3f, 0.3f}) {
        const fuse_flow::Intrinsics& K = cameras[0].intrinsics;
        const fuse_flow::Ray ray = unproject(K, {static_cast<float>(u), static_cast<float>(v)});
        const fuse_flow::Pixel at = project(K, {2 * ray.x + baseline, 2 * ray.y, 2});
        expected += at.u >= -0.5f && at.u < 59.5f && at.v >= -0.5f && at.v < 39.5f ? 1 : 0;
      }
  FuseFlowParameters parameters = agreementAlone(1);
  parameters.agreement.pixels = 0.05f;
  const std::size_t agreed = scenes::fuse(scenes::makeFlatScene(cameras, {2, 2}).rig, parameters).size();
  EXPECT_NEAR(static_cast<double>(agreed), static_cast<double>(expected), 2);
  EXPECT_GT(expected, 3000u);
  EXPECT_LT(expected, 2u * 60 * 40);
}

TEST(Agreement, ComparesTheRefinedDepthOfBothViews) {
  // 6 mm of noise on each: as measured, views are within 2 mm of one another now and then, refined nearly always.
  Scene scene = scenes::wall(3);
  scenes::addNoise(scene, 0.006f);
  const auto agreed = [&](int passes) {
    FuseFlowParameters parameters = agreementAlone(1);
    parameters.smoothing.passes = passes;
    parameters.adapt_noise = true;
    parameters.agreement.relative = 0.002f / 1.5f;
    return scenes::fuse(scene.rig, parameters).size();
  };
  const std::size_t all = scene.depth.size() * scene.depth[0].data.size();
  EXPECT_LT(agreed(0), all / 2);
  EXPECT_GT(agreed(4), all * 4 / 5);
}

/** \brief Five views of a ball before a wall, with noise and wrong patches. */
Scene patchyScene() {
  Scene scene = scenes::makeScene(scenes::cameraRow(5), scenes::ballAndWall());
  scenes::addNoise(scene, 0.008f);
  for (std::size_t i = 0; i < scene.depth.size(); ++i)
    for (int v = 0; v < 24; ++v)
      for (int u = 0; u < 24; ++u) {
        float& z = scene.depth[i].at(10 + 13 * static_cast<int>(i) + u, 20 + v);
        z = u % 7 == 0 ? 0 : 0.9f * z;
      }
  return scene;
}

TEST(Agreement, KeepsWhatMatricesInDoublePrecisionSay) {
  const Scene scene = patchyScene();
  for (const int min_views : {1, 2, 4}) {
    FuseFlowParameters parameters = agreementAlone(min_views);
    parameters.agreement.pixels = 0.8f;
    parameters.agreement.relative = 0.008f;
    const Cloud cloud = scenes::fuse(scene.rig, parameters);
    std::vector<Eigen::Vector3f> expected;
    std::vector<bool> close;
    for (std::size_t i = 0; i < scene.depth.size(); ++i) {
      const fuse_flow::Camera& camera = scene.rig.cameras[i];
      for (int v = 0; v < scene.depth[i].height; ++v)
        for (int u = 0; u < scene.depth[i].width; ++u) {
          const float z = scene.depth[i].at(u, v);
          if (!(z > 0)) continue;
          const int n = agreeing(scene, parameters.agreement, i, u, v);
          if (n >= 0 && n < min_views) continue;
          const fuse_flow::Ray ray = unproject(camera.intrinsics, {static_cast<float>(u), static_cast<float>(v)});
          expected.emplace_back(
              (camera.T_world_camera *
               Vector3d(static_cast<double>(ray.x * z), static_cast<double>(ray.y * z), static_cast<double>(z)))
                  .cast<float>());
          close.push_back(n < 0);
        }
    }
    // In the order of the pixels; those close to the limits may be there or not.
    std::size_t k = 0, undecided = 0;
    for (std::size_t e = 0; e < expected.size(); ++e) {
      const bool there = k < cloud.size() && (cloud[k].getVector3fMap() - expected[e]).norm() < 1e-5f;
      ASSERT_TRUE(there || close[e]) << min_views << " views, point " << e;
      k += there ? 1 : 0;
      undecided += close[e] ? 1 : 0;
    }
    EXPECT_EQ(k, cloud.size()) << min_views;
    EXPECT_LT(undecided, scene.depth.size() * scene.depth[0].data.size() / 20);
    EXPECT_GT(cloud.size(), 1000u) << min_views;
    EXPECT_LT(cloud.size(), scene.depth.size() * scene.depth[0].data.size() - 500);
  }
}

TEST(Agreement, ThreadsDoNotMatterHoweverManyPassesShareMaps) {
  // Large enough for several stretches; with passes, whose maps the views share.
  std::vector<fuse_flow::Camera> cameras = scenes::cameraRow(4, 400, 300, 380);
  Scene scene = scenes::makeScene(cameras, scenes::ballAndWall());
  scenes::addNoise(scene, 0.004f);
  for (const int passes : {0, 3, 4}) {
    FuseFlowParameters parameters = FuseFlowParameters::estimatedDepth();
    parameters.smoothing.passes = passes;
    const Cloud one = scenes::fuse(scene.rig, parameters, 1);
    EXPECT_GT(one.size(), 1000u);
    for (const unsigned int threads : {2u, 3u})
      EXPECT_EQ(scenes::bytes(scenes::fuse(scene.rig, parameters, threads)), scenes::bytes(one)) << passes;
  }
}

TEST(Agreement, TheOrderOfTheCamerasDoesNotMatter) {
  Scene scene = patchyScene();
  const Cloud cloud = scenes::fuse(scene.rig, agreementAlone(2));
  std::reverse(scene.rig.cameras.begin(), scene.rig.cameras.end());
  std::reverse(scene.rig.views.begin(), scene.rig.views.end());
  const Cloud reversed = scenes::fuse(scene.rig, agreementAlone(2));
  EXPECT_EQ(cloud.size(), reversed.size());
  EXPECT_EQ(scenes::withoutPartner(cloud, reversed, 1e-5f), 0u);
}

/** \brief How many points are more than 50 mm before the wall of three cameras: one is wrong in a patch where the others have holes, so that
 *  nobody contradicts it. */
std::size_t floating(const FuseFlowParameters& parameters, std::size_t& points) {
  Scene scene = scenes::wall(3);
  for (std::size_t i = 0; i < 3; ++i)
    for (int v = 16; v < 56; ++v)
      for (int u = 10; u < 86; ++u)
        if (float& z = scene.depth[i].at(u, v); i == 1) {
          if (u >= 38 && u < 58 && v >= 26 && v < 46) z *= 0.8f;
        } else {
          z = 0;
        }
  const Cloud cloud = scenes::fuse(scene.rig, parameters);
  points = cloud.size();
  return static_cast<std::size_t>(
      std::count_if(cloud.begin(), cloud.end(), [](const auto& point) { return point.z < 1.45f; }));
}

TEST(Agreement, OneWrongPatchThatNobodyContradictsStaysOfADepthCameraAndGoesOfANetwork) {
  std::size_t points = 0;
  EXPECT_GT(floating({}, points), 100u);
  FuseFlowParameters parameters = FuseFlowParameters::estimatedDepth();
  parameters.agreement.min_views = 1;
  EXPECT_EQ(floating(parameters, points), 0u);
  EXPECT_GT(points, 500u);
}

TEST(Agreement, AContradictionCountsAsMuchAsItsPixelIsSure) {
  fuse_flow::ConsistencyParameters p;
  const auto V = [&p](const std::vector<float>& confidences) {
    fuse_flow::Consistency c;
    for (const float confidence : confidences) c.add(p, {fuse_flow::ViewOpinion::SeenThrough, 0, confidence});
    return consistency(p, c);
  };
  EXPECT_FLOAT_EQ(V({0.5f}), p.free_space_penalty);  // each counts in full
  p.weigh_contradictions = true;
  EXPECT_FLOAT_EQ(V({}), 1);
  EXPECT_FLOAT_EQ(V({0}), 1);
  EXPECT_FLOAT_EQ(V({1}), p.free_space_penalty);
  EXPECT_FLOAT_EQ(V({0.5f}), 0.5f * p.free_space_penalty + 0.5f);
  EXPECT_FLOAT_EQ(V({1, 0.5f}), p.free_space_penalty * (0.5f * p.free_space_penalty + 0.5f));
}

TEST(Agreement, WhoIsNotSureDoesNotContradict) {
  // The first camera measures a wall at 1.5 m, the second, in the same place, sees through it.
  Scene scene = scenes::makeFlatScene(scenes::sameCameras(2, 60, 40, 50), {1.5f, 2.5f});
  const auto weight = [&](float sure, const FuseFlowParameters& parameters) {
    scene.confidence = {scenes::uniform(60, 40, 1), scenes::uniform(60, 40, sure)};
    scene.attach();
    const Cloud cloud = scenes::fuse(scene.rig, parameters);
    float most = 0;
    for (const auto& point : cloud)
      if (point.z < 2) most = std::max(most, point.confidence);
    return most;
  };
  for (const auto distance : {fuse_flow::DistanceForm::AlongRay, fuse_flow::DistanceForm::Euclidean})
    for (const bool spatial_hash : {true, false}) {
      FuseFlowParameters parameters;
      parameters.consistency.distance = distance;
      parameters.use_spatial_hash = spatial_hash;
      for (const float sure : {0.0f, 1.0f}) EXPECT_LT(weight(sure, parameters), 0.04f) << sure;
      parameters.consistency.weigh_contradictions = true;
      EXPECT_GT(weight(0, parameters), 0.5f);
      EXPECT_LT(weight(1, parameters), 0.04f);
      EXPECT_GT(weight(NAN, parameters), 0.5f);
      EXPECT_NEAR(weight(0.5f, parameters), 0.515f * weight(0, parameters), 0.01f);
    }
}

TEST(Agreement, EstimatedDepthIsTheDefaultsButForWhatItSays) {
  const FuseFlowParameters p = FuseFlowParameters::estimatedDepth();
  EXPECT_EQ(p.agreement.min_views, 2);
  EXPECT_FALSE(p.adapt_noise);
  EXPECT_EQ(p.smoothing.tolerance, 4);
  EXPECT_EQ(p.smoothing.wide_above, 0);
  EXPECT_TRUE(p.consistency.weigh_contradictions);
  EXPECT_EQ(p.consistency.margin, 2);
  EXPECT_EQ(p.consistency.max_views, 16);
  EXPECT_EQ(p.consistency.max_candidates, 16);
  EXPECT_EQ(p.aggregation.confirmation_reach, 0.04f);
  EXPECT_NO_THROW(checkParameters(p));
  EXPECT_EQ(FuseFlowParameters().agreement.min_views, 0);
  EXPECT_EQ(FuseFlowParameters::published().agreement.min_views, 0);
  EXPECT_FALSE(FuseFlowParameters::published().consistency.weigh_contradictions);
}

}  // namespace
