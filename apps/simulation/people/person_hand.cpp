#include "simulation/people/person_hand.h"

#include "simulation/people/person_skeleton.h"
#include "simulation/portable_math.h"
#include "simulation/surfaces/implicit_surface.h"
#include "simulation/surfaces/vertex_normals.h"

#include <algorithm>
#include <utility>

namespace fuse_flow::simulation {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Eigen::Vector3f;
using portable::turn;

/** \brief One finger of an open left hand. */
struct FingerShape {
  Vector3d joints[4];
  double radii[4];
  /** \brief About which it bends towards the palm. */
  Vector3d hinge;
  /** \brief Radians at its three joints, and towards the others, in a fist. */
  double bends[3];
  double together;
};

FingerShape fingerShape(double x, double z, double lean, double length, double radius) {
  const Vector3d along(portable::sin(lean), 0, portable::cos(lean));
  // The three bones of a finger are as 1 : 0.62 : 0.5.
  const double bones[] = {length / 2.12, 0.62 * length / 2.12, 0.5 * length / 2.12};
  FingerShape f{
      {Vector3d(x, 0, z)}, {1.1 * radius, radius, 0.9 * radius, 0.75 * radius}, {}, {1.45, 1.75, 1.0}, 0.9 * lean};
  f.hinge = along.cross(-Vector3d::UnitY());
  for (int k = 0; k < 3; ++k) f.joints[k + 1] = f.joints[k] + bones[k] * along;
  return f;
}

/** \brief From the index finger; the thumb is the last. */
const std::vector<FingerShape>& fingerShapes() {
  static const std::vector<FingerShape> all = [] {
    std::vector<FingerShape> made = {
        fingerShape(-0.030, 0.098, -0.20, 0.074, 0.0085), fingerShape(-0.010, 0.104, -0.06, 0.082, 0.0090),
        fingerShape(0.010, 0.101, 0.08, 0.077, 0.0086), fingerShape(0.029, 0.091, 0.24, 0.062, 0.0076),
        fingerShape(-0.024, 0.034, -0.80, 0.078, 0.0105)};
    FingerShape& thumb = made.back();
    thumb.bends[0] = 0.75;
    thumb.bends[1] = 0.5;
    thumb.bends[2] = 0.7;
    thumb.together = -0.55;
    return made;
  }();
  return all;
}

double boneDistance(const FingerShape& f, std::size_t bone, const Vector3d& p) {
  return capsuleDistance(p, f.joints[bone], f.joints[bone + 1], f.radii[bone], f.radii[bone + 1]);
}

double palmDistance(const Vector3d& p) {
  // Flatter than wide.
  double f = capsuleDistance(p.cwiseProduct(Vector3d(1, 1.35, 1)), {0, 0, 0.022}, {0, 0, 0.05}, 0.027, 0.029);
  f = smoothUnion(f, capsuleDistance(p, {0, 0, -0.03}, {0, 0, 0.02}, 0.023, 0.025), 0.012);
  for (const double x : {-0.022, -0.007, 0.007, 0.022})
    f = smoothUnion(f, capsuleDistance(p, {0.6 * x, 0, 0.04}, {1.15 * x, 0, 0.097}, 0.016, 0.0115), 0.012);
  return f;
}

double handDistance(const Vector3d& p) {
  double f = palmDistance(p);
  for (const FingerShape& of : fingerShapes()) {
    double own = 1;
    for (std::size_t bone = 0; bone < 3; ++bone) own = smoothUnion(own, boneDistance(of, bone, p), 0.003);
    f = smoothUnion(f, own, 0.008);
  }
  return f;
}

}  // namespace

PersonHand::PersonHand()
    : rest_(polygonise(handDistance, {Vector3d(-0.125, -0.05, -0.06), Vector3d(0.075, 0.05, 0.205)}, 0.003)) {
  constexpr double passage = 0.004;  // metres over which a bone's weight passes to the next
  for (const Vector3f& v : rest_.vertices) {
    std::array<double, kBones> distances;
    distances[0] = palmDistance(v.cast<double>());
    for (std::size_t k = 0; k < kFingers * kPhalanges; ++k)
      distances[1 + k] = boneDistance(fingerShapes()[k / kPhalanges], k % kPhalanges, v.cast<double>());
    const double best = *std::min_element(distances.begin(), distances.end());
    double sum = 0;
    for (double& d : distances) sum += d = portable::exp(-(d - best) / passage);
    std::array<float, kBones>& weights = weights_.emplace_back();
    for (std::size_t k = 0; k < kBones; ++k) weights[k] = static_cast<float>(distances[k] / sum);
  }
}

std::array<Isometry3d, PersonHand::kBones> PersonHand::bonesOf(double closed) const {
  std::array<Isometry3d, kBones> bones;
  bones[0] = Isometry3d::Identity();
  for (std::size_t k = 0; k < kFingers; ++k) {
    const FingerShape& f = fingerShapes()[k];
    Isometry3d before = about(f.joints[0], turn(-closed * f.together, Vector3d::UnitY()));
    for (std::size_t bone = 0; bone < kPhalanges; ++bone) {
      before = before * about(f.joints[bone], turn(closed * f.bends[bone], f.hinge));
      bones[1 + k * kPhalanges + bone] = before;
    }
  }
  return bones;
}

Object PersonHand::posed(const Isometry3d& T_world_hand, double side, double closed) const {
  const std::array<Isometry3d, kBones> bones = bonesOf(closed);
  const Vector3d mirror(side > 0 ? 1 : -1, 1, 1);
  Object hand;
  hand.name = "skin";
  hand.part = "hand";
  hand.material = skin();
  TriangleMesh& mesh = hand.mesh;
  mesh.triangles = rest_.triangles;
  if (side < 0)
    for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  for (std::size_t k = 0; k < rest_.vertices.size(); ++k) {
    const Vector3d p = rest_.vertices[k].cast<double>();
    Vector3d moved = Vector3d::Zero();
    for (std::size_t bone = 0; bone < kBones; ++bone)
      moved += static_cast<double>(weights_[k][bone]) * (bones[bone] * p);
    mesh.vertices.push_back((T_world_hand * moved.cwiseProduct(mirror)).cast<float>());
    mesh.rest.push_back(p.cwiseProduct(mirror).cast<float>());
  }
  mesh.normals = vertexNormals(mesh.vertices, mesh.triangles);
  return hand;
}

}  // namespace fuse_flow::simulation
