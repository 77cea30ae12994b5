#pragma once

#include "simulation/surfaces/implicit_surface.h"
#include "simulation/surfaces/mesh.h"

#include <Eigen/Geometry>

#include <array>
#include <vector>

namespace fuse_flow::simulation {

/** \brief The rigid parts of a person. The left ones follow the right ones. */
enum Bone {
  Pelvis,
  Chest,
  Head,
  ThighRight,
  ShankRight,
  FootRight,
  UpperArmRight,
  ForearmRight,
  ThighLeft,
  ShankLeft,
  FootLeft,
  UpperArmLeft,
  ForearmLeft,
  kBoneCount
};

/** \brief How every bone moved from its place in the rest pose. */
using Pose = std::array<Eigen::Isometry3d, kBoneCount>;

/** \brief Joints of the rest pose: facing x, left is y, soles on z = 0, between the feet x = y = 0; arms half lowered. side:
 *  −1 right, 1 left. Metres. */
namespace rest_pose {
Eigen::Vector3d hip(double side);
Eigen::Vector3d knee(double side);
Eigen::Vector3d ankle(double side);
Eigen::Vector3d shoulder(double side);
Eigen::Vector3d elbow(double side);
Eigen::Vector3d wrist(double side);
Eigen::Vector3d waist();
Eigen::Vector3d neck();
}  // namespace rest_pose

Material skin();

/** \brief Simple: stiff, the fingers together. None: arms end at the wrist, where a PersonHand goes on. */
enum class Hands { Simple, None };

/** \brief A person 1.75 m tall in clothes, who bends by linear-blend skinning: the same triangles in every pose. */
class PersonBody {
 public:
  explicit PersonBody(Hands hands = Hands::Simple);

  /** \brief One object for each material of each part; together they are one closed surface. */
  std::vector<Object> posed(const Pose& pose) const;

  /** \brief What the surface of the rest pose is the zero of. */
  static double distance(const Eigen::Vector3d& p, Hands hands = Hands::Simple);

 private:
  /** \brief What one material covers of a part, with vertices of its own. */
  struct Patch {
    Object object;                      // in the rest pose
    std::vector<std::uint32_t> vertex;  // number in body_
  };

  TriangleMesh body_;  // in the rest pose
  std::vector<std::array<float, kBoneCount>> weights_;
  std::vector<Patch> patches_;
};

}  // namespace fuse_flow::simulation
