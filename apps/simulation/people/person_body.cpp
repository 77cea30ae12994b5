#include "simulation/people/person_body.h"

#include "simulation/portable_math.h"
#include "simulation/surfaces/vertex_normals.h"

#include <algorithm>
#include <cmath>

namespace fuse_flow::simulation {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

enum Cloth { kShirt, kTrousers, kShoe, kSkin, kHair, kClothCount };
// In the order of personParts().
enum Limb { kHead, kTorso, kArm, kHand, kLeg, kFoot, kLimbCount };

/** \brief A capsule of the body: flattened along x by a factor about its first end. */
struct Part {
  Bone bone;
  Limb limb;
  Cloth cloth;
  Vector3d from, to;
  double radius_from, radius_to;
  double flat{1};

  double distance(const Vector3d& p) const {
    const Vector3d q(from.x() + (p.x() - from.x()) / flat, p.y(), p.z());
    return capsuleDistance(q, from, to, radius_from, radius_to);
  }

  /** \brief How far from it the body begins to flow into it, metres: bulky parts do, fingers and face keep their shape. */
  double blend() const { return std::clamp(0.8 * std::min(radius_from, radius_to), 0.008, 0.05); }

  /** \brief How much distance() can change over a way of one metre. */
  double steepest() const {
    return (1 + std::fabs(radius_to - radius_from) / (to - from).norm()) * std::max(1.0, 1 / flat);
  }
};

void addSide(std::vector<Part>& parts, double side, Hands hands) {
  using namespace rest_pose;
  const int left = side > 0 ? ThighLeft - ThighRight : 0;
  const auto bone = [left](Bone right) { return static_cast<Bone>(right + left); };
  const Vector3d down = (wrist(side) - elbow(side)).normalized();
  const Vector3d calf = knee(side) + 0.3 * (ankle(side) - knee(side)) + Vector3d(-0.012, 0, 0);
  parts.push_back({bone(ThighRight), kLeg, kTrousers, hip(side), knee(side), 0.088, 0.058});
  parts.push_back({bone(ShankRight), kLeg, kTrousers, knee(side), calf, 0.057, 0.057});
  parts.push_back({bone(ShankRight), kLeg, kTrousers, calf, ankle(side) + Vector3d(0, 0, 0.03), 0.057, 0.046});
  const Vector3d sole(ankle(side).x(), ankle(side).y(), 0);
  parts.push_back({bone(FootRight), kFoot, kShoe, sole + Vector3d(-0.03, 0, 0.045),
                   sole + Vector3d(0.1, 0.015 * side, 0.043), 0.044, 0.042});
  parts.push_back({bone(FootRight), kFoot, kShoe, sole + Vector3d(0.08, 0.012 * side, 0.042),
                   sole + Vector3d(0.17, 0.02 * side, 0.034), 0.041, 0.033});
  parts.push_back({bone(FootRight), kFoot, kShoe, sole + Vector3d(-0.01, 0, 0.06), ankle(side), 0.045, 0.043});
  parts.push_back({bone(UpperArmRight), kArm, kShirt, shoulder(side), elbow(side), 0.056, 0.046});
  parts.push_back({bone(ForearmRight), kArm, kSkin, elbow(side), wrist(side), 0.040, 0.028});
  if (hands == Hands::None) return;
  const Vector3d palm = wrist(side) + 0.085 * down, tips = wrist(side) + 0.165 * down;
  parts.push_back({bone(ForearmRight), kHand, kSkin, wrist(side) + 0.03 * down, palm, 0.028, 0.031});
  for (const double x : {-0.021, 0.0, 0.021})
    parts.push_back({bone(ForearmRight), kHand, kSkin, palm + Vector3d(x, 0, 0), tips + Vector3d(1.2 * x, 0, 0.008),
                     0.0125, 0.0095});
  const Vector3d thumb = wrist(side) + 0.035 * down + Vector3d(0.025, 0, 0);
  parts.push_back(
      {bone(ForearmRight), kHand, kSkin, thumb, thumb + 0.055 * down + Vector3d(0.03, 0, 0), 0.0145, 0.0105});
}

std::vector<Part> makeParts(Hands hands) {
  std::vector<Part> parts;
  parts.push_back({Pelvis, kTorso, kTrousers, {0, -0.065, 0.93}, {0, 0.065, 0.93}, 0.112, 0.112, 0.92});
  parts.push_back({Pelvis, kTorso, kShirt, {0, 0, 0.99}, {0, 0, 1.1}, 0.15, 0.145, 0.72});
  parts.push_back({Chest, kTorso, kShirt, {0, 0, 1.12}, {0, 0, 1.3}, 0.145, 0.168, 0.68});
  parts.push_back({Chest, kTorso, kShirt, {-0.005, -0.125, 1.385}, {-0.005, 0.125, 1.385}, 0.068, 0.068, 1.1});
  parts.push_back({Chest, kHead, kSkin, {-0.01, 0, 1.42}, {0.0, 0, 1.52}, 0.058, 0.054});
  parts.push_back({Head, kHead, kSkin, {0.012, 0, 1.575}, {0.0, 0, 1.655}, 0.070, 0.088, 1.12});
  parts.push_back({Head, kHead, kSkin, {0.10, 0, 1.605}, {0.086, 0, 1.635}, 0.015, 0.009});  // nose
  parts.push_back({Head, kHead, kHair, {-0.022, 0, 1.63}, {-0.014, 0, 1.668}, 0.087, 0.092, 1.12});
  for (const double side : {-1.0, 1.0}) {
    addSide(parts, side, hands);
    parts.push_back(
        {Head, kHead, kSkin, {-0.005, 0.084 * side, 1.595}, {-0.012, 0.09 * side, 1.63}, 0.010, 0.014});  // ears
  }
  return parts;
}

const std::vector<Part>& partsWith(Hands hands) {
  static const std::vector<Part> all = makeParts(Hands::Simple), without = makeParts(Hands::None);
  return hands == Hands::None ? without : all;
}

/** \brief Where the body is, with what is around it. */
Eigen::AlignedBox3d bodyBounds() { return {Vector3d(-0.3, -0.75, -0.03), Vector3d(0.3, 0.75, 1.82)}; }

/** \brief For each cell of a grid the parts that distance() depends on in it. A point has a few of them, the body forty. */
class PartsByCell {
 public:
  explicit PartsByCell(Hands hands) : parts_(partsWith(hands)) {
    for (int k = 0; k < size_.z(); ++k)
      for (int j = 0; j < size_.y(); ++j)
        for (int i = 0; i < size_.x(); ++i)
          cells_.push_back(partsNear(bounds_.min() + kCell * (Vector3d(i, j, k) + Vector3d::Constant(0.5))));
  }

  const std::vector<Part>& at(const Vector3d& p) const {
    if (!bounds_.contains(p)) return parts_;
    const Eigen::Array3i cell = ((p - bounds_.min()) / kCell).array().cast<int>().min(size_ - 1);
    return cells_[static_cast<std::size_t>((cell.z() * size_.y() + cell.y()) * size_.x() + cell.x())];
  }

 private:
  static constexpr double kCell = 0.05;

  /** \brief Goes through the parts as distance() does, with bounds of its value in the cell. Left out are those that smoothUnion()
   *  gives back the other of, and those before one that it gives back: the value is the same to the bit. */
  std::vector<Part> partsNear(const Vector3d& centre) const {
    constexpr double half_diagonal = 0.8661 * kCell;
    std::vector<Part> near;
    double least = 1, most = 1;
    for (const Part& part : parts_) {
      const double d = part.distance(centre), off = half_diagonal * part.steepest() + 1e-6, blend = part.blend();
      if (d - off > most + blend) continue;
      if (d + off < least - blend) {
        near.clear();
        least = d - off;
      } else {
        least = std::min(least, d - off) - 0.25 * blend;
      }
      most = std::min(most, d + off);
      near.push_back(part);
    }
    return near;
  }

  const std::vector<Part>& parts_;
  const Eigen::AlignedBox3d bounds_ = bodyBounds();
  const Eigen::Array3i size_ = (bounds_.sizes() / kCell).array().ceil().cast<int>();
  std::vector<std::vector<Part>> cells_;
};

Material materialOf(Cloth cloth) {
  switch (cloth) {
    case kShirt:
      return {Material::Stripes, {196, 64, 52}, {232, 222, 204}, 0.11f, 0.7f};
    case kTrousers:
      return {Material::Noise, {58, 82, 128}, {36, 52, 88}, 0.04f, 0.4f};
    case kShoe:
      return {Material::Plain, {90, 62, 44}, {}, 0.1f, 0.3f};
    case kSkin:
      return skin();
    default:
      return {Material::Noise, {62, 42, 30}, {32, 22, 18}, 0.015f, 0.1f};
  }
}

/** \brief What a point of the surface belongs to. */
const Part& partAt(const Vector3d& p, Hands hands) {
  double least = 1e9;
  const Part* nearest = nullptr;
  for (const Part& part : partsWith(hands)) {
    const double d = part.distance(p);
    if (d < least) {
      least = d;
      nearest = &part;
    }
  }
  return *nearest;
}

/** \brief Weights of the bones; they sum to 1 and pass from bone to bone over a few centimetres around a joint. */
std::array<float, kBoneCount> weightsAt(const Vector3d& p, Hands hands) {
  constexpr double passage = 0.02;
  std::array<double, kBoneCount> nearest;
  nearest.fill(1e9);
  for (const Part& part : partsWith(hands)) nearest[part.bone] = std::min(nearest[part.bone], part.distance(p));
  const double best = *std::min_element(nearest.begin(), nearest.end());
  std::array<float, kBoneCount> weights;
  double sum = 0;
  for (double& d : nearest) sum += d = portable::exp(-(d - best) / passage);
  for (std::size_t k = 0; k < kBoneCount; ++k) weights[k] = static_cast<float>(nearest[k] / sum);
  return weights;
}

}  // namespace

Material skin() { return {Material::Noise, {226, 176, 146}, {212, 156, 126}, 0.05f, 0.6f}; }

namespace rest_pose {
Vector3d hip(double side) { return {0, 0.092 * side, 0.90}; }
Vector3d knee(double side) { return {0.005, 0.11 * side, 0.49}; }
Vector3d ankle(double side) { return {-0.01, 0.12 * side, 0.09}; }
Vector3d shoulder(double side) { return {-0.005, 0.185 * side, 1.39}; }
Vector3d elbow(double side) { return shoulder(side) + 0.28 * Vector3d(0, 0.6 * side, -0.8); }
Vector3d wrist(double side) { return elbow(side) + 0.25 * Vector3d(0, 0.6 * side, -0.8); }
Vector3d waist() { return {0, 0, 1.08}; }
Vector3d neck() { return {-0.005, 0, 1.5}; }
}  // namespace rest_pose

double PersonBody::distance(const Vector3d& p, Hands hands) {
  static const PartsByCell with(Hands::Simple), without(Hands::None);
  double f = 1;
  for (const Part& part : (hands == Hands::None ? without : with).at(p))
    f = smoothUnion(f, part.distance(p), part.blend());
  return f;
}

PersonBody::PersonBody(Hands hands) {
  constexpr const char* names[] = {"shirt", "trousers", "shoes", "skin", "hair"};
  body_ = polygonise([hands](const Vector3d& p) { return distance(p, hands); }, bodyBounds(), 0.009);
  for (const Vector3f& v : body_.vertices) weights_.push_back(weightsAt(v.cast<double>(), hands));
  constexpr std::uint32_t none = ~0u;
  constexpr std::size_t count = std::size_t{kClothCount} * kLimbCount;
  std::vector<Patch> patches(count);
  std::vector<std::vector<std::uint32_t>> own(count, std::vector<std::uint32_t>(body_.vertices.size(), none));
  for (const auto& t : body_.triangles) {
    const Vector3d middle = ((body_.vertices[t[0]] + body_.vertices[t[1]] + body_.vertices[t[2]]) / 3).cast<double>();
    const Part& part = partAt(middle, hands);
    const std::size_t at = static_cast<std::size_t>(part.cloth) * kLimbCount + static_cast<std::size_t>(part.limb);
    Patch& patch = patches[at];
    std::array<std::uint32_t, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) {
      std::uint32_t& number = own[at][t[k]];
      if (number == none) {
        number = static_cast<std::uint32_t>(patch.vertex.size());
        patch.vertex.push_back(t[k]);
        patch.object.mesh.rest.push_back(body_.vertices[t[k]]);
      }
      corners[k] = number;
    }
    patch.object.mesh.triangles.push_back(corners);
  }
  for (std::size_t at = 0; at < count; ++at) {
    if (patches[at].vertex.empty()) continue;
    Object& object = patches[at].object;
    object.name = names[at / kLimbCount];
    object.material = materialOf(static_cast<Cloth>(at / kLimbCount));
    object.part = personParts()[at % kLimbCount];
    object.surface = static_cast<std::uint32_t>(at / kLimbCount + 1);
    patches_.push_back(std::move(patches[at]));
  }
}

std::vector<Object> PersonBody::posed(const Pose& pose) const {
  std::vector<Vector3f> vertices(body_.vertices.size());
  for (std::size_t k = 0; k < vertices.size(); ++k) {
    Eigen::Matrix<double, 3, 4> blended = Eigen::Matrix<double, 3, 4>::Zero();
    for (std::size_t bone = 0; bone < kBoneCount; ++bone)
      blended += static_cast<double>(weights_[k][bone]) * pose[bone].matrix().topRows<3>();
    vertices[k] = (blended * body_.vertices[k].cast<double>().homogeneous()).cast<float>();
  }
  const std::vector<Vector3f> normals = vertexNormals(vertices, body_.triangles);
  std::vector<Object> objects;
  for (const Patch& patch : patches_) {
    objects.push_back(patch.object);
    for (const std::uint32_t k : patch.vertex) {
      objects.back().mesh.vertices.push_back(vertices[k]);
      objects.back().mesh.normals.push_back(normals[k]);
    }
  }
  return objects;
}

}  // namespace fuse_flow::simulation
