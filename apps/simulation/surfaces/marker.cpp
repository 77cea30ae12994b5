#include "simulation/surfaces/marker.h"

#include "simulation/portable_math.h"
#include "simulation/surfaces/shapes.h"

#include <algorithm>
#include <cmath>

namespace fuse_flow::simulation {

Object makeMarker(double side, const Eigen::AlignedBox3f& subject, double time) {
  using Eigen::Vector3f;
  constexpr double turns_per_second = 0.3, kTwoPi = 6.283185307179586;
  const double around = kTwoPi * turns_per_second * time;
  const double nod = 0.5 + 0.3 * portable::sin(2.3 * around);  // radians that it is tilted up
  const Vector3f faces(static_cast<float>(portable::cos(nod) * portable::cos(around)),
                       static_cast<float>(portable::cos(nod) * portable::sin(around)),
                       static_cast<float>(portable::sin(nod)));
  const Vector3f centre = subject.center();
  const float height = std::min(subject.max().z() + 0.5f * static_cast<float>(side), centre.z() + 0.45f);
  Eigen::Isometry3f T = Eigen::Isometry3f::Identity();
  T.linear().col(2) = faces;
  T.linear().col(0) = Vector3f::UnitZ().cross(faces).normalized();
  T.linear().col(1) = faces.cross(T.linear().col(0));
  T.translation() = Vector3f(centre.x(), centre.y(), height) + 0.15f * Vector3f(faces.x(), faces.y(), 0);
  const float cell = static_cast<float>(side) / 8;  // the black square is eight cells wide; one white cell around it
  TriangleMesh plate = moved(box({10 * cell, 10 * cell, 0.004f}), {0, 0, -0.002f});
  plate.rest = plate.vertices;
  return {"marker", moved(std::move(plate), T), {Material::Marker, {235, 235, 235}, {25, 25, 25}, cell, 0.7f}};
}

}  // namespace fuse_flow::simulation
