#pragma once

#include "simulation/people/person_body.h"
#include "simulation/people/person_hand.h"

#include <Eigen/Geometry>

#include <array>
#include <vector>

namespace fuse_flow::simulation {

/** \brief A turn about an axis through a joint. */
Eigen::Isometry3d about(const Eigen::Vector3d& joint, const Eigen::Quaterniond& rotation);

/** \brief Thigh, shank and foot, the knee bent towards forward. The pelvis is placed. side: −1 right, 1 left.
 *  \param foot how the foot moved from the rest pose */
void placeLeg(Pose& pose, double side, const Eigen::Isometry3d& foot, const Eigen::Vector3d& forward);

/** \brief What a person does with one side at an instant; world frame. */
struct SidePosture {
  /** \brief How the foot moved from the rest pose. */
  Eigen::Isometry3d foot{Eigen::Isometry3d::Identity()};
  /** \brief Where the wrist is, metres; the arm is 0.53 m long. */
  Eigen::Vector3d wrist{Eigen::Vector3d::Zero()};
  /** \brief Directions: to which the elbow points, and the thumb; where the fingers point, zero: as the forearm does. */
  Eigen::Vector3d elbow{-Eigen::Vector3d::UnitX()};
  Eigen::Vector3d thumb{Eigen::Vector3d::UnitX()};
  Eigen::Vector3d fingers{Eigen::Vector3d::Zero()};
  /** \brief From an open hand to a fist, 0 to 1. */
  double closed{0};
};

struct Posture {
  /** \brief How the pelvis moved from the rest pose. */
  Eigen::Isometry3d pelvis{Eigen::Isometry3d::Identity()};
  /** \brief Of the chest to the pelvis and of the head to the chest, radians; leaning is forward. */
  double chest_turn{0};
  double chest_lean{0.05};
  double head_turn{0};
  double head_lean{0};
  /** \brief Right, left. */
  std::array<SidePosture, 2> sides;

  SidePosture& side(double side) { return sides[side > 0 ? 1 : 0]; }
  const SidePosture& side(double side) const { return sides[side > 0 ? 1 : 0]; }
};

/** \brief Where the chest is in a posture: how it moved from the rest pose. */
Eigen::Isometry3d chestOf(const Posture& posture);

/** \brief A person with hands that open and close. */
class PersonFigure {
 public:
  PersonFigure() : body_(Hands::None) {}
  std::vector<Object> posed(const Posture& posture) const;

 private:
  PersonBody body_;
  PersonHand hand_;
};

}  // namespace fuse_flow::simulation
