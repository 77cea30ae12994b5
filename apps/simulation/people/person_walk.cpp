#include "simulation/people/person_walk.h"

#include "simulation/people/person_skeleton.h"
#include "simulation/pi.h"
#include "simulation/portable_math.h"

#include <algorithm>
#include <cmath>

namespace fuse_flow::simulation {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using portable::turn;

constexpr double kSpeed = 1.0;   // m/s
constexpr double kStride = 1.0;  // metres that one foot goes from step to step
constexpr double kStance = 0.6;  // share of the time that a foot stands
constexpr double kHipHeight = 0.865;
constexpr int kSteps = 4096;

double smooth(double t) { return t * t * t * (t * (6 * t - 15) + 10); }  // no jerk at either end

}  // namespace

PersonWalk::PersonWalk(double half_length, double half_width, double phase)
    : half_length_(half_length), half_width_(half_width), start_(0), length_to_{0} {
  const auto place = [&](int k) {
    const double u = 2 * kPi * k / kSteps;
    return Eigen::Vector2d(half_length_ * portable::sin(u), half_width_ * portable::sin(2 * u));
  };
  for (int k = 1; k <= kSteps; ++k) length_to_.push_back(length_to_.back() + (place(k) - place(k - 1)).norm());
  start_ = phase * length_to_.back();
}

Isometry3d PersonWalk::onPath(double distance) const {
  const double whole = length_to_.back();
  const double length = distance - whole * std::floor(distance / whole);
  const auto next = std::upper_bound(length_to_.begin() + 1, length_to_.end() - 1, length);
  const double part = (length - *(next - 1)) / (*next - *(next - 1));
  const double u = 2 * kPi * (static_cast<double>(next - length_to_.begin() - 1) + part) / kSteps;
  Isometry3d T = Isometry3d::Identity();
  T.translate(Vector3d(half_length_ * portable::sin(u), half_width_ * portable::sin(2 * u), 0));
  T.rotate(turn(portable::atan2(2 * half_width_ * portable::cos(2 * u), half_length_ * portable::cos(u)),
                Vector3d::UnitZ()));
  return T;
}

Isometry3d PersonWalk::foot(double walked, double side) const {
  // Stands half a stance ahead of the hip when it lands, and is passed while it stands.
  const double steps = walked / kStride + (side > 0 ? 0.5 : 0.0);
  const double step = std::floor(steps), part = steps - step;
  const double landed = (step + 0.5 * kStance - (side > 0 ? 0.5 : 0.0)) * kStride;
  const double swing = std::max(0.0, (part - kStance) / (1 - kStance));
  const double lift = portable::sin(kPi * swing) * portable::sin(kPi * swing);
  Isometry3d T = onPath(landed + smooth(swing) * kStride);
  const Vector3d ankle = rest_pose::ankle(side);
  T.translate(Vector3d(0, -0.03 * side, 0.1 * lift));  // steps are narrower than the rest pose
  return T * about(ankle, turn(0.4 * lift * (1 - 1.4 * swing), Vector3d::UnitY()));
}

Pose PersonWalk::pose(double time) const {
  const double walked = start_ + kSpeed * time;
  const double swing = 2 * kPi * walked / kStride;  // right foot lands at 0
  const Isometry3d ground = onPath(walked);
  const double sink = kHipHeight - rest_pose::hip(1).z() - 0.012 * portable::cos(2 * swing);
  Pose pose;
  pose[Pelvis] = ground * Eigen::Translation3d(0, 0, sink) *
                 about(rest_pose::waist(), turn(0.06 * portable::cos(swing), Vector3d::UnitZ()));
  pose[Chest] = pose[Pelvis] * about(rest_pose::waist(), turn(-0.16 * portable::cos(swing), Vector3d::UnitZ()) *
                                                             turn(0.05, Vector3d::UnitY()));
  pose[Head] =
      pose[Chest] *
      about(rest_pose::neck(), turn(0.1 * portable::cos(swing) + 0.35 * portable::sin(0.7 * time), Vector3d::UnitZ()));
  for (const double side : {-1.0, 1.0}) {
    const std::size_t left = side > 0 ? ThighLeft - ThighRight : 0;
    const Isometry3d foot_motion = foot(walked, side);
    placeLeg(pose, side, foot_motion, ground.linear().col(0) + foot_motion.linear().col(0));
    // The arm swings against the leg of its side; forward is a turn by a negative angle about y.
    const double ahead = side * 0.42 * portable::cos(swing);
    const Vector3d shoulder = rest_pose::shoulder(side), elbow = rest_pose::elbow(side);
    pose[UpperArmRight + left] =
        pose[Chest] * about(shoulder, turn(-ahead, Vector3d::UnitY()) * turn(-0.44 * side, Vector3d::UnitX()));
    const Vector3d hinge = (elbow - shoulder).cross(Vector3d::UnitX()).normalized();
    pose[ForearmRight + left] = pose[UpperArmRight + left] * about(elbow, turn(0.45 + 0.3 * ahead, hinge));
  }
  return pose;
}

}  // namespace fuse_flow::simulation
