#include <fuse_flow/camera.h>
#include <fuse_flow/math/pinhole.h>

#include <gtest/gtest.h>

#include <cmath>

namespace {

using namespace fuse_flow;

Intrinsics ideal() {
  Intrinsics K;
  K.width = 640;
  K.height = 480;
  K.fx = 500;
  K.fy = 400;
  K.cx = 320;
  K.cy = 240;
  return K;
}

/** \brief The narrow depth mode of an Azure Kinect: rational, and strongly curved at the corners. */
Intrinsics azureDepth() {
  Intrinsics K;
  K.width = 640;
  K.height = 576;
  K.fx = K.fy = 504.3f;
  K.cx = 320.6f;
  K.cy = 330.4f;
  K.distortion = {5.2025f, 3.7001f, 1.02e-5f, -6.9e-5f, 0.2024f, 5.5320f, 5.4433f, 1.0286f};
  return K;
}

/** \brief A wide colour camera: Brown-Conrady, barrel. */
Intrinsics barrelColor() {
  Intrinsics K = ideal();
  K.fx = K.fy = 600;
  K.distortion.k1 = -0.28f;
  K.distortion.k2 = 0.07f;
  K.distortion.p1 = 4e-4f;
  K.distortion.p2 = -3e-4f;
  return K;
}

void expectPixelsSurviveTheLens(const Intrinsics& K) {
  constexpr int steps = 60;  // from corner to corner
  for (int j = 0; j <= steps; ++j)
    for (int i = 0; i <= steps; ++i) {
      const Pixel pixel{static_cast<float>((K.width - 1) * i) / steps, static_cast<float>((K.height - 1) * j) / steps};
      const Pixel back = project(K, pointOnRay(unproject(K, pixel), 2.5f));
      ASSERT_NEAR(back.u, pixel.u, 2e-3f) << "at " << pixel.u << ", " << pixel.v;
      ASSERT_NEAR(back.v, pixel.v, 2e-3f) << "at " << pixel.u << ", " << pixel.v;
    }
}

void expectRaysSurviveTheLens(const Distortion& lens, float reach) {
  for (int k = -20; k <= 20; ++k)
    for (int m = -20; m <= 20; ++m) {
      const Ray ray{reach * static_cast<float>(k) / 20, reach * static_cast<float>(m) / 20};
      const Ray back = undistort(lens, distort(lens, ray));
      ASSERT_NEAR(back.x, ray.x, 1e-5f) << "at " << ray.x << ", " << ray.y;
      ASSERT_NEAR(back.y, ray.y, 1e-5f) << "at " << ray.x << ", " << ray.y;
    }
}

TEST(Pinhole, ProjectsAPointOnTheOpticalAxisToThePrincipalPoint) {
  const Pixel pixel = project(ideal(), {0, 0, 3});
  EXPECT_EQ(pixel.u, 320.0f);
  EXPECT_EQ(pixel.v, 240.0f);
}

TEST(Pinhole, ProjectsByHandKnownNumbers) {
  // x/z = 0.25 and y/z = -0.5: u = 500 · 0.25 + 320, v = 400 · (-0.5) + 240.
  const Pixel pixel = project(ideal(), {0.5f, -1.0f, 2.0f});
  EXPECT_FLOAT_EQ(pixel.u, 445.0f);
  EXPECT_FLOAT_EQ(pixel.v, 40.0f);
}

TEST(Pinhole, UnprojectsByHandKnownNumbers) {
  const Ray ray = unproject(ideal(), {445.0f, 40.0f});
  EXPECT_FLOAT_EQ(ray.x, 0.25f);
  EXPECT_FLOAT_EQ(ray.y, -0.5f);
  const Vec3 p = pointOnRay(ray, 2.0f);
  EXPECT_FLOAT_EQ(p.x, 0.5f);
  EXPECT_FLOAT_EQ(p.y, -1.0f);
  EXPECT_FLOAT_EQ(p.z, 2.0f);
}

TEST(Pinhole, AnAllZeroLensIsIdealAndAnyCoefficientMakesItNot) {
  EXPECT_TRUE(isIdeal({}));
  for (int k = 0; k < 8; ++k) {
    Distortion d;
    float* const coefficients[] = {&d.k1, &d.k2, &d.p1, &d.p2, &d.k3, &d.k4, &d.k5, &d.k6};
    *coefficients[k] = 0.01f;
    EXPECT_FALSE(isIdeal(d)) << "coefficient " << k;
  }
}

TEST(Pinhole, DistortsRadiallyByHandKnownNumbers) {
  Distortion d;
  d.k1 = 0.1f;
  d.k2 = 0.2f;
  d.k3 = 0.3f;
  // r² = 4: s = 1 + 0.1·4 + 0.2·16 + 0.3·64 = 23.8.
  const Ray ray = distort(d, {0, 2});
  EXPECT_FLOAT_EQ(ray.x, 0.0f);
  EXPECT_FLOAT_EQ(ray.y, 47.6f);
}

TEST(Pinhole, DividesByTheRationalTermByHandKnownNumbers) {
  Distortion d;
  d.k1 = 1.0f;
  d.k4 = 0.5f;
  d.k5 = 0.25f;
  d.k6 = 0.25f;
  // r² = 1: s = 2 / (1 + 0.5 + 0.25 + 0.25) = 1; r² = 4: s = 5 / (1 + 2 + 4 + 16) = 5/23.
  EXPECT_FLOAT_EQ(distort(d, {1, 0}).x, 1.0f);
  EXPECT_FLOAT_EQ(distort(d, {2, 0}).x, 10.0f / 23.0f);
}

TEST(Pinhole, DistortsTangentiallyByHandKnownNumbers) {
  Distortion d;
  d.p1 = 0.1f;
  d.p2 = 0.2f;
  // r² = 5: x + 2·0.1·1·2 + 0.2·(5 + 2) = 2.8; y + 0.1·(5 + 8) + 2·0.2·1·2 = 4.1.
  const Ray ray = distort(d, {1, 2});
  EXPECT_FLOAT_EQ(ray.x, 2.8f);
  EXPECT_FLOAT_EQ(ray.y, 4.1f);
}

TEST(Pinhole, ProjectionGoesThroughTheLens) {
  Intrinsics K = ideal();
  K.distortion.k1 = 0.5f;
  // x/z = 0.5, r² = 0.25, s = 1.125: u = 500 · 0.5625 + 320.
  const Pixel pixel = project(K, {1, 0, 2});
  EXPECT_FLOAT_EQ(pixel.u, 601.25f);
  EXPECT_FLOAT_EQ(pixel.v, 240.0f);
}

TEST(Pinhole, UndistortSolvesACubicKnownByHand) {
  Distortion d;
  d.k1 = 0.5f;
  // x (1 + x²/2) = 1.5 has the root 1, = 6 has the root 2.
  EXPECT_NEAR(undistort(d, {1.5f, 0}).x, 1.0f, 1e-6f);
  EXPECT_NEAR(undistort(d, {0, 6.0f}).y, 2.0f, 2e-6f);
}

TEST(Pinhole, PixelsOfAnIdealLensSurviveBothWays) { expectPixelsSurviveTheLens(ideal()); }

TEST(Pinhole, PixelsOfABrownConradyLensSurviveBothWaysUpToTheCorners) { expectPixelsSurviveTheLens(barrelColor()); }

TEST(Pinhole, PixelsOfARationalLensSurviveBothWaysUpToTheCorners) { expectPixelsSurviveTheLens(azureDepth()); }

TEST(Pinhole, RaysSurviveABrownConradyLens) { expectRaysSurviveTheLens(barrelColor().distortion, 0.6f); }

TEST(Pinhole, RaysSurviveARationalLens) { expectRaysSurviveTheLens(azureDepth().distortion, 0.85f); }

TEST(Pinhole, UndistortStaysFiniteWhereTheLensModelFoldsOver) {
  Distortion d;
  d.k1 = -0.5f;  // r - r³/2 never exceeds 0.544: no ray at all maps to 2
  const Ray ray = undistort(d, {2.0f, 0.0f});
  EXPECT_TRUE(std::isfinite(ray.x));
  EXPECT_TRUE(std::isfinite(ray.y));
}

TEST(Pinhole, WhereTheLensModelFoldsOverNoRayReachesThePixel) {
  Intrinsics K = ideal();
  K.distortion.k1 = -0.5f;  // r − r³/2 grows up to r = √(2/3) = 0.816, where it is 0.544
  EXPECT_NEAR(foldRadius(K.distortion), 0.8165f, 0.009f);
  const auto reached = [&](float radius) {
    const Pixel pixel{K.cx + K.fx * radius, K.cy};
    return reaches(K, unproject(K, pixel), pixel);
  };
  for (const float radius : {0.0f, 0.2f, 0.5f, 0.54f}) EXPECT_TRUE(reached(radius)) << radius;
  for (const float radius : {0.55f, 0.7f, 1.0f, 3.0f}) EXPECT_FALSE(reached(radius)) << radius;
  EXPECT_TRUE(reaches(ideal(), unproject(ideal(), {-5000, 0}), {-5000, 0}));
  for (const Distortion& grows : {Distortion{}, azureDepth().distortion, barrelColor().distortion})
    EXPECT_GT(foldRadius(grows), 0.9f);
}

TEST(Pinhole, ProjectionMatrixWithIdentityPoseIsKByHand) {
  const Vec3 q = projectionMatrix(ideal(), {}) * Vec3{0.5f, -1.0f, 2.0f};
  EXPECT_FLOAT_EQ(q.x, 2 * 445.0f);
  EXPECT_FLOAT_EQ(q.y, 2 * 40.0f);
  EXPECT_FLOAT_EQ(q.z, 2.0f);
}

TEST(Pinhole, ProjectionMatrixAgreesWithTransformingAndProjecting) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  T.translation() << 0.3, -0.2, 2.5;
  const RigidTransform T_camera_world = toRigidTransform(T);
  const ProjectionMatrix P = projectionMatrix(ideal(), T_camera_world);
  for (int k = 0; k < 100; ++k) {
    const Vec3 p{0.1f * static_cast<float>(k % 10 - 5), 0.07f * static_cast<float>(k / 10 - 5),
                 0.05f * static_cast<float>(k % 7)};
    const Vec3 p_C = T_camera_world * p;
    ASSERT_GT(p_C.z, 0);
    const Pixel expected = project(ideal(), p_C);
    const Vec3 q = P * p;
    EXPECT_NEAR(q.z, p_C.z, 1e-5f);
    EXPECT_NEAR(q.x / q.z, expected.u, 2e-3f);
    EXPECT_NEAR(q.y / q.z, expected.v, 2e-3f);
  }
}

TEST(RigidTransform, MovesByHandKnownNumbers) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;  // x → −y, y → −z, z → x
  T.translation() << 1, 2, 3;
  const Vec3 p = toRigidTransform(T) * Vec3{10, 20, 30};
  EXPECT_EQ(p.x, 31.0f);
  EXPECT_EQ(p.y, -8.0f);
  EXPECT_EQ(p.z, -17.0f);
}

}  // namespace
