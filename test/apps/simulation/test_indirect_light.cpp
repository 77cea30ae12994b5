#include "mesh_checks.h"

#include "simulation/indirect_light.h"
#include "simulation/sensor.h"

#include <fuse_flow/impl/sensors/multipath_correction.hpp>

#include <cmath>
#include <complex>

namespace {

using namespace fuse_flow::simulation;
using fuse_flow::Intrinsics;
using fuse_flow::io::FloatImage;
using mesh_checks::Vector3f;

constexpr float kPeriod = 0.75f, kReflectance = 0.6f;

/** \brief Two walls, x = −z + 2 and x = z − 2: they meet at z = 2 in a right angle that opens towards the camera at the origin. */
Vector3f normalOf(bool left) { return Vector3f(left ? 1.0f : -1.0f, 0, -1).normalized(); }
float depthOn(bool left, float x) { return left ? 2 + x : 2 - x; }

RayScene corner() {
  std::vector<Object> walls;
  for (const bool left : {true, false}) {
    Object wall = mesh_checks::squareFacingUp(30, 0);
    const Eigen::Quaternionf turn = Eigen::Quaternionf::FromTwoVectors(Vector3f::UnitZ(), normalOf(left));
    for (Vector3f& v : wall.mesh.vertices) v = turn * v + Vector3f(0, 0, 2);
    wall.material.infrared = kReflectance;
    walls.push_back(wall);
  }
  RayScene scene;
  scene.setFixed(walls);
  return scene;
}

Intrinsics wideCamera() {
  Intrinsics K;
  K.width = K.height = 240;
  K.fx = K.fy = 200;
  K.cx = K.cy = 119.5f;
  return K;
}

/** \brief Wall by wall, in strips of 8 mm: what a lamp at the origin, which lights what it sees, sends by the other wall to a
 *  place on the right one. */
std::complex<double> integral(const Intrinsics& K, const Vector3f& place) {
  constexpr double step = 0.008;
  std::complex<double> sum = 0;
  const Vector3f n = normalOf(false), m = normalOf(true);
  for (double x = step / 2 - 2; x < 0; x += step)  // left wall: x < 0
    for (double y = -3; y < 3; y += step) {
      const auto fx = static_cast<float>(x), fy = static_cast<float>(y);
      const Vector3f source(fx, fy, depthOn(true, fx));
      const float u = K.fx * source.x() / source.z() + K.cx, v = K.fy * source.y() / source.z() + K.cy;
      if (u < 0 || v < 0 || u > static_cast<float>(K.width) || v > static_cast<float>(K.height)) continue;
      const double area = step * step * std::sqrt(2.0);
      const Vector3f between = place - source;
      const double r = static_cast<double>(source.norm()), d = static_cast<double>(between.norm());
      const double lit = static_cast<double>(-m.dot(source)) / r / (r * r);
      const double sent = static_cast<double>(m.dot(between)) / d, received = static_cast<double>(-n.dot(between)) / d;
      const double light =
          static_cast<double>(kReflectance) * lit * sent * received / (3.141592653589793 * d * d) * area;
      const double extra = (r + d - static_cast<double>(place.norm())) / 2;
      sum += std::polar(light, 2 * 3.141592653589793 * extra / static_cast<double>(kPeriod));
    }
  return sum;
}

TEST(IndirectLight, AreAllTheLightThatComesByTheOtherWall) {
  const Intrinsics K = wideCamera();
  const RayScene scene = corner();
  const IndirectLight indirect(scene, K, Eigen::Isometry3d::Identity(), kPeriod, 1, 2);
  for (const auto& [u, v] : {std::pair{130, 120}, std::pair{150, 120}, std::pair{180, 60}, std::pair{210, 180}}) {
    const float x = (static_cast<float>(u) - K.cx) / K.fx, y = (static_cast<float>(v) - K.cy) / K.fy;
    const float z = 2 / (1 + x);  // on the right wall, z = 2 − x z
    const std::complex<double> expected = integral(K, {x * z, y * z, z});
    const IndirectLight::Light light = indirect.at(u, v);
    EXPECT_NEAR(static_cast<double>(light.in_phase), expected.real(), 0.04 * std::abs(expected)) << u << ", " << v;
    EXPECT_NEAR(static_cast<double>(light.behind), expected.imag(), 0.04 * std::abs(expected)) << u << ", " << v;
    EXPECT_GT(std::abs(expected), 0.003) << "there is something to compare";
  }
}

TEST(IndirectLight, AreNoneOnAWallAloneNorWhereNothingIsSeen) {
  Object wall = mesh_checks::squareFacingUp(1, 0);
  for (Vector3f& v : wall.mesh.vertices) v = Vector3f(v.x(), -v.y(), 2 - v.z());
  RayScene scene;
  scene.setFixed({wall});
  const IndirectLight indirect(scene, wideCamera(), Eigen::Isometry3d::Identity(), kPeriod, 1, 2);
  for (const auto& [u, v] : {std::pair{120, 120}, std::pair{0, 0}}) {
    EXPECT_EQ(indirect.at(u, v).in_phase, 0.0f);
    EXPECT_EQ(indirect.at(u, v).behind, 0.0f);
  }
}

TEST(IndirectLight, HaveNoNoiseOfTheirOwn) {
  // The noise of both sensors is the same, number by number: their difference is what indirect light does, and is smooth.
  const RayScene scene = corner();
  FloatImage with, without;
  makeSensor("time_of_flight_multipath", 0.5)->measure(scene, Eigen::Isometry3d::Identity(), {1, 0, 0}, 2, with);
  makeSensor("time_of_flight", 0.5)->measure(scene, Eigen::Isometry3d::Identity(), {1, 0, 0}, 2, without);
  double squares = 0, sum = 0;
  int count = 0;
  const int v = with.height / 2;
  for (int u = with.width / 2 + 8; u < with.width / 2 + 90; ++u) {
    const auto late = [&](int i) { return static_cast<double>(with.at(i, v) - without.at(i, v)); };
    if (!(with.at(u - 1, v) > 0) || !(with.at(u, v) > 0) || !(with.at(u + 1, v) > 0)) continue;
    const double second = late(u - 1) - 2 * late(u) + late(u + 1);
    squares += second * second;
    sum += late(u);
    ++count;
  }
  ASSERT_GT(count, 60);
  EXPECT_GT(std::abs(sum) / count, 0.002) << "metres of bias";
  EXPECT_LT(std::sqrt(squares / count / 6), 0.0008) << "noise of a pixel, metres";
}

TEST(IndirectLight, AreTakenFromWhatASensorMeasuresInACorner) {
  const auto sensor = makeSensor("time_of_flight_multipath", 0.5);
  const RayScene scene = corner();
  FloatImage measured;
  sensor->measure(scene, Eigen::Isometry3d::Identity(), {1, 0, 0}, 2, measured);
  fuse_flow::Camera camera;
  camera.intrinsics = sensor->intrinsics();
  camera.multipath = {sensor->modulationFrequency(), kReflectance};
  fuse_flow::host::ViewGeometry geometry;
  geometry.assign(camera);
  fuse_flow::host::DepthMap depth;
  depth.resize(measured.width, measured.height);
  for (int v = 0; v < measured.height; ++v)
    for (int u = 0; u < measured.width; ++u) depth.row(v)[u] = measured.at(u, v);
  fuse_flow::host::MultipathCorrection().correct(geometry, depth);
  // Of the mean of a column, which has little noise.
  double before = 0, after = 0;
  int count = 0;
  for (int u = measured.width / 2 + 4; u < measured.width / 2 + 80; ++u) {
    const double x = static_cast<double>(geometry.ray(u, 0).x), truth = 2 / (1 + x);
    double late = 0, left = 0, n = 0;
    for (int v = measured.height / 2 - 20; v < measured.height / 2 + 20; ++v) {
      if (!(measured.at(u, v) > 0)) continue;
      late += static_cast<double>(measured.at(u, v)) - truth;
      left += static_cast<double>(depth.row(v)[u]) - truth;
      n += 1;
    }
    if (n < 30) continue;
    before += std::fabs(late / n);
    after += std::fabs(left / n);
    ++count;
  }
  ASSERT_GT(count, 60);
  EXPECT_GT(before / count, 0.005);
  EXPECT_LT(after, 0.25 * before);
}

}  // namespace
