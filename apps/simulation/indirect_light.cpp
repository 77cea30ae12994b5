#include "simulation/indirect_light.h"

#include "simulation/pi.h"
#include "simulation/portable_math.h"
#include "simulation/random.h"

#include <fuse_flow/impl/host/parallel.hpp>

#include <algorithm>
#include <cmath>

namespace fuse_flow::simulation {
namespace {

using Eigen::Vector3f;

/** \brief Directions are 6 × 6 strata of the hemisphere. */
constexpr int kStrata = 6;
/** \brief Pixels to each side that share their directions, where they see the same surface … */
constexpr int kReach = 3;
/** \brief … within this distance, metres, and this cosine between their normals. */
constexpr float kNear = 0.03f, kParallel = 0.98f;

/** \brief A number that objects share which are one surface. */
std::uint32_t surfaceOf(const RayScene& scene, std::uint32_t object) {
  const std::uint32_t surface = scene.object(object).surface;
  return surface > 0 ? scene.objectCount() + surface : object;
}

Vector3f towards(const Vector3f& normal, const Vector3f& direction) {
  return normal.dot(direction) > 0 ? normal : Vector3f(-normal);
}

}  // namespace

float returnedLight(const RayScene& scene, const SurfacePoint& surface, const Vector3f& lamp) {
  const Vector3f back = lamp - surface.position;
  const float squared = std::max(back.squaredNorm(), 1e-4f);
  return scene.object(surface.object).material.infrared * std::fabs(surface.normal.dot(back)) /
         (squared * std::sqrt(squared));
}

IndirectLight::IndirectLight(const Exposure& exposure, const Intrinsics& K, const Eigen::Isometry3d& T_world_camera,
                             float period, std::uint64_t seed, int threads)
    : width_(K.width),
      height_(K.height),
      radians_per_metre_(kPiF / period),
      receivers_(static_cast<std::size_t>(K.width) * static_cast<std::size_t>(K.height)) {
  const PixelRays rays(K, T_world_camera);
  host::parallelFor(threads, static_cast<std::size_t>(K.height), [&](std::size_t row, int) {
    for (int u = 0; u < K.width; ++u)
      receivers_[row * static_cast<std::size_t>(width_) + static_cast<std::size_t>(u)] =
          receive(exposure, rays, u, static_cast<int>(row), seed);
  });
}

IndirectLight::Receiver IndirectLight::receive(const Exposure& exposure, const PixelRays& rays, int u, int v,
                                               std::uint64_t seed) const {
  Receiver receiver;
  const RayScene& scene = exposure.scene();
  const float moment = exposure.moment(v, height_);
  const RayHit hit =
      scene.intersect(rays.origin(), rays.direction(static_cast<float>(u), static_cast<float>(v)), moment);
  if (!hit) return receiver;
  const Vector3f back = rays.origin() - hit.position;
  const Vector3f normal = towards(hit.normal, back), tangent = normal.unitOrthogonal(), other = normal.cross(tangent);
  receiver.position = hit.position;
  receiver.normal = normal;
  receiver.distance = back.norm();
  receiver.surface = surfaceOf(scene, hit.object);
  Random random(seed, static_cast<std::uint64_t>(v), static_cast<std::uint64_t>(u), 0);
  for (int k = 0; k < kStrata * kStrata; ++k) {
    // As a matt surface receives: by the cosine.
    const auto stratum = [&](int i) {
      return (static_cast<float>(i) + static_cast<float>(random.uniform())) / static_cast<float>(kStrata);
    };
    const float angle = 2 * kPiF * stratum(k % kStrata), squared_radius = stratum(k / kStrata);
    const float radius = std::sqrt(squared_radius);
    const Vector3f direction = radius * portable::cos(angle) * tangent + radius * portable::sin(angle) * other +
                               std::sqrt(std::max(1 - squared_radius, 0.0f)) * normal;
    const RayHit bounce = scene.intersect(hit.position + 1e-3f * normal, direction, moment);
    // The sensor lights what it sees, and little beyond.
    if (!bounce || !rays.reach(bounce.position) || scene.occluded(rays.origin(), bounce.position, 2e-3f, moment))
      continue;
    const float light = returnedLight(scene, bounce, rays.origin()) / static_cast<float>(kStrata * kStrata);
    const float phase = radians_per_metre_ * ((bounce.position - rays.origin()).norm() + bounce.t);
    receiver.real += light * portable::cos(phase);
    receiver.imaginary += light * portable::sin(phase);
  }
  return receiver;
}

IndirectLight::Light IndirectLight::at(int u, int v) const {
  const Receiver& own = receiver(u, v);
  if (!(own.distance > 0)) return {};
  float real = 0, imaginary = 0, count = 0;
  for (int b = std::max(v - kReach, 0); b <= std::min(v + kReach, height_ - 1); ++b)
    for (int a = std::max(u - kReach, 0); a <= std::min(u + kReach, width_ - 1); ++a) {
      const Receiver& other = receiver(a, b);
      if (!(other.distance > 0) || other.surface != own.surface || other.normal.dot(own.normal) < kParallel ||
          (other.position - own.position).squaredNorm() > kNear * kNear)
        continue;
      real += other.real;
      imaginary += other.imaginary;
      count += 1;
    }
  const float c = portable::cos(radians_per_metre_ * own.distance),
              s = portable::sin(radians_per_metre_ * own.distance);
  return {(c * real + s * imaginary) / count, (c * imaginary - s * real) / count};
}

}  // namespace fuse_flow::simulation
