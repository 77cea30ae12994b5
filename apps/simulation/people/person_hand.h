#pragma once

#include "simulation/surfaces/mesh.h"

#include <Eigen/Geometry>

#include <array>
#include <vector>

namespace fuse_flow::simulation {

/** \brief A hand of five fingers of three bones each, which opens and closes by linear-blend skinning. In its own frame the wrist
 *  is the origin, the fingers point along z and the palm faces −y; a left hand's thumb is on the side of −x, a right hand's on
 *  that of x. */
class PersonHand {
 public:
  PersonHand();

  /** \brief A closed surface that begins inside the forearm. side: −1 right, 1 left.
   *  \param closed from fingers that are straight and spread to a fist, 0 to 1 */
  Object posed(const Eigen::Isometry3d& T_world_hand, double side, double closed) const;

 private:
  static constexpr std::size_t kFingers = 5, kPhalanges = 3, kBones = 1 + kFingers * kPhalanges;

  std::array<Eigen::Isometry3d, kBones> bonesOf(double closed) const;

  TriangleMesh rest_;  // a left one, open
  std::vector<std::array<float, kBones>> weights_;
};

}  // namespace fuse_flow::simulation
