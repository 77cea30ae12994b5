#include "simulation/people/skirt.h"

#include "simulation/people/person_motions.h"
#include "simulation/pi.h"
#include "simulation/portable_math.h"
#include "simulation/surfaces/vertex_normals.h"

namespace fuse_flow::simulation {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kWaist = 0.99, kLength = 0.46, kThickness = 0.002;  // height, from waist to hem, metres
constexpr std::uint32_t kAround = 216, kDown = 56;

/** \brief A point of the sheet's outer side, world frame. \param part of the way from waist to hem */
Vector3d skirtPoint(double around, double part, double time) {
  const double turned = twist(time - 0.12 * part);
  const double phase = 2 * kPi * time / 1.6;
  const double flare = 0.72 + 0.08 * portable::cos(2 * phase) + 0.2 * part * portable::sin(7 * around + phase);
  const double across = part * kLength * portable::sin(flare);
  const double x = (0.128 + across) * portable::cos(around), y = (0.17 + across) * portable::sin(around);
  const double c = portable::cos(turned), s = portable::sin(turned);
  return {c * x - s * y, s * x + c * y, kWaist - part * kLength * portable::cos(flare)};
}

/** \brief Both sides of the sheet, the outer one first, and its two rims. */
std::vector<std::array<std::uint32_t, 3>> sheetTriangles() {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  constexpr std::uint32_t inner = kAround * (kDown + 1);
  const auto quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    triangles.push_back({a, b, c});
    triangles.push_back({a, c, d});
  };
  for (std::uint32_t i = 0; i < kAround; ++i) {
    const std::uint32_t next = (i + 1) % kAround;
    for (std::uint32_t k = 0; k < kDown; ++k) {
      const std::uint32_t above = k * kAround, below = above + kAround;
      quad(below + i, below + next, above + next, above + i);
      quad(inner + below + i, inner + above + i, inner + above + next, inner + below + next);
    }
    constexpr std::uint32_t hem = kAround * kDown;
    quad(i, next, inner + next, inner + i);
    quad(hem + i, inner + hem + i, inner + hem + next, hem + next);
  }
  return triangles;
}

}  // namespace

Object skirt(double time) {
  static const std::vector<std::array<std::uint32_t, 3>> triangles = sheetTriangles();
  Object object{"skirt", {}, {Material::Stripes, {150, 50, 110}, {236, 190, 90}, 0.09f, 0.6f}};
  std::vector<Vector3f> inner;
  for (std::uint32_t k = 0; k <= kDown; ++k)
    for (std::uint32_t i = 0; i < kAround; ++i) {
      const double around = 2 * kPi * i / kAround, part = static_cast<double>(k) / kDown;
      constexpr double step = 1e-3;
      const Vector3d p = skirtPoint(around, part, time);
      const Vector3d along = skirtPoint(around + step, part, time) - skirtPoint(around - step, part, time);
      const Vector3d down = skirtPoint(around, part + step, time) - skirtPoint(around, part - step, time);
      object.mesh.vertices.push_back(p.cast<float>());
      inner.push_back((p - kThickness * down.cross(along).normalized()).cast<float>());
      object.mesh.rest.push_back(skirtPoint(around, part, 0).cast<float>());
    }
  object.mesh.vertices.insert(object.mesh.vertices.end(), inner.begin(), inner.end());
  const std::vector<Vector3f> rest = object.mesh.rest;
  object.mesh.rest.insert(object.mesh.rest.end(), rest.begin(), rest.end());
  object.mesh.triangles = triangles;
  object.mesh.normals = vertexNormals(object.mesh.vertices, triangles);
  return object;
}

}  // namespace fuse_flow::simulation
