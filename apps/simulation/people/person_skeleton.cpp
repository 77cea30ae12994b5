#include "simulation/people/person_skeleton.h"

#include "simulation/portable_math.h"

#include <algorithm>
#include <cmath>

namespace fuse_flow::simulation {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using portable::turn;

/** \brief Columns: forward, left, up along a bone that points down. */
Matrix3d boneFrame(const Vector3d& down, const Vector3d& forward) {
  Matrix3d R;
  R.col(2) = -down.normalized();
  R.col(1) = R.col(2).cross(forward).normalized();
  R.col(0) = R.col(1).cross(R.col(2));
  return R;
}

/** \brief How a bone moved that was between two joints in the rest pose, facing x, and now lies along another line. */
Isometry3d boneMotion(const Vector3d& from_rest, const Vector3d& to_rest, const Vector3d& from, const Vector3d& to,
                      const Vector3d& forward) {
  Isometry3d T = Isometry3d::Identity();
  T.linear() = boneFrame(to - from, forward) * boneFrame(to_rest - from_rest, Vector3d::UnitX()).transpose();
  T.translation() = from - T.linear() * from_rest;
  return T;
}

/** \brief The knee or elbow between two joints, bent towards a direction (law of cosines). */
Vector3d jointBetween(const Vector3d& from, const Vector3d& to, double first, double second, const Vector3d& towards) {
  const double reach = std::min((to - from).norm(), 0.999 * (first + second));
  const Vector3d down = (to - from).normalized();
  const double along = (first * first - second * second + reach * reach) / (2 * reach);
  const Vector3d ahead = (towards - towards.dot(down) * down).normalized();
  return from + along * down + std::sqrt(std::max(first * first - along * along, 0.0)) * ahead;
}

/** \brief Upper arm and forearm. Returns where the hand is, in PersonHand's frame. */
Isometry3d placeArm(Pose& pose, double side, const SidePosture& posture) {
  const std::size_t left = side > 0 ? ThighLeft - ThighRight : 0;
  const Vector3d shoulder_rest = rest_pose::shoulder(side), elbow_rest = rest_pose::elbow(side),
                 wrist_rest = rest_pose::wrist(side);
  const double upper = (elbow_rest - shoulder_rest).norm(), fore = (wrist_rest - elbow_rest).norm();
  const Vector3d shoulder = pose[Chest] * shoulder_rest;
  const Vector3d elbow = jointBetween(shoulder, posture.wrist, upper, fore, posture.elbow);
  const Vector3d forearm = (posture.wrist - elbow).normalized(), wrist = elbow + fore * forearm;
  pose[UpperArmRight + left] = boneMotion(shoulder_rest, elbow_rest, shoulder, elbow, -posture.elbow);
  // The forearm turns with the hand, though not as far.
  pose[ForearmRight + left] = boneMotion(elbow_rest, wrist_rest, elbow, wrist, posture.thumb - 0.7 * posture.elbow);
  const Vector3d fingers = posture.fingers.norm() > 0 ? Vector3d(posture.fingers.normalized()) : forearm;
  Isometry3d hand = Isometry3d::Identity();
  hand.translation() = wrist;
  hand.linear().col(2) = fingers;
  hand.linear().col(0) = -side * (posture.thumb - posture.thumb.dot(fingers) * fingers).normalized();
  hand.linear().col(1) = fingers.cross(Vector3d(hand.linear().col(0)));
  return hand;
}

}  // namespace

Isometry3d about(const Vector3d& joint, const Eigen::Quaterniond& rotation) {
  Isometry3d T = Isometry3d::Identity();
  T.translate(joint);
  T.rotate(rotation);
  T.translate(-joint);
  return T;
}

void placeLeg(Pose& pose, double side, const Isometry3d& foot, const Vector3d& forward) {
  const std::size_t left = side > 0 ? ThighLeft - ThighRight : 0;
  const Vector3d hip_rest = rest_pose::hip(side), knee_rest = rest_pose::knee(side),
                 ankle_rest = rest_pose::ankle(side);
  const Vector3d hip = pose[Pelvis] * hip_rest, ankle = foot * ankle_rest;
  const Vector3d knee =
      jointBetween(hip, ankle, (knee_rest - hip_rest).norm(), (ankle_rest - knee_rest).norm(), forward);
  pose[ThighRight + left] = boneMotion(hip_rest, knee_rest, hip, knee, forward);
  pose[ShankRight + left] = boneMotion(knee_rest, ankle_rest, knee, ankle, forward);
  pose[FootRight + left] = foot;
}

Isometry3d chestOf(const Posture& posture) {
  return posture.pelvis * about(rest_pose::waist(), turn(posture.chest_turn, Vector3d::UnitZ()) *
                                                        turn(posture.chest_lean, Vector3d::UnitY()));
}

std::vector<Object> PersonFigure::posed(const Posture& posture) const {
  Pose pose;
  pose[Pelvis] = posture.pelvis;
  pose[Chest] = chestOf(posture);
  pose[Head] = pose[Chest] * about(rest_pose::neck(), turn(posture.head_turn, Vector3d::UnitZ()) *
                                                          turn(posture.head_lean, Vector3d::UnitY()));
  std::array<Isometry3d, 2> hands;
  for (const double side : {-1.0, 1.0}) {
    const SidePosture& mine = posture.side(side);
    placeLeg(pose, side, mine.foot, posture.pelvis.linear().col(0) + mine.foot.linear().col(0));
    hands[side > 0 ? 1 : 0] = placeArm(pose, side, mine);
  }
  std::vector<Object> objects = body_.posed(pose);
  for (const double side : {-1.0, 1.0})
    objects.push_back(hand_.posed(hands[side > 0 ? 1 : 0], side, posture.side(side).closed));
  return objects;
}

}  // namespace fuse_flow::simulation
