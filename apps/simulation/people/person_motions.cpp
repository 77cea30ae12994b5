#include "simulation/people/person_motions.h"

#include "simulation/pi.h"
#include "simulation/portable_math.h"
#include "simulation/scenes/track.h"

#include <cmath>

namespace fuse_flow::simulation {
namespace {

using Eigen::Isometry3d;
using Eigen::Translation3d;
using Eigen::Vector3d;
using portable::turn;

/** \brief Knees are a little bent when somebody stands: how much lower the pelvis is than in the rest pose, metres. */
constexpr double kStandingSink = 0.035;

Vector3d hipCentre() { return 0.5 * (rest_pose::hip(-1) + rest_pose::hip(1)); }

/** \brief The pelvis elsewhere, leaning forward. */
Isometry3d pelvisAt(double x, double up, double lean) {
  return Translation3d(x, 0, up) * about(hipCentre(), turn(lean, Vector3d::UnitY()));
}

Vector3d shoulderOf(const Posture& posture, double side) { return chestOf(posture) * rest_pose::shoulder(side); }

/** \brief A nearly straight arm that swings: at angle 0 it hangs, at π/2 it is stretched forward. */
void swingArm(Posture& posture, double side, double angle) {
  SidePosture& mine = posture.side(side);
  const double c = portable::cos(angle), s = portable::sin(angle);
  mine.wrist = shoulderOf(posture, side) + 0.49 * Vector3d(s, 0.14 * side, -c).normalized();
  mine.elbow = Vector3d(-c, 0.3 * side, -s);
  mine.thumb = Vector3d(c, 0, s);
  mine.closed = 0.25;
}

Isometry3d footAt(double side, double x, double y, double angle) {
  const Vector3d ankle = rest_pose::ankle(side);
  return Translation3d(x, y, 0) * about(ankle, turn(angle, Vector3d::UnitZ()));
}

}  // namespace

Posture punching(double time) {
  // Of the left hand; the right one does the same a second later.
  static const Track reach{{0, 0},   {0.4, 0},  {0.51, 1}, {0.56, 1}, {0.86, 0},
                           {2.4, 0}, {2.51, 1}, {2.56, 1}, {2.86, 0}, {4, 0}};
  static const Track closed{{0, 1}, {1.4, 1}, {1.8, 0.06}, {3.2, 0.06}, {3.6, 1}, {4, 1}};
  const double left = reach.at(time), right = reach.at(time - 1);
  const double breath = 0.008 * portable::sin(2 * kPi * 0.5 * time);
  Posture posture;
  const double turned = 0.45 * right - 0.3 * left;
  posture.pelvis = Translation3d(0.03 * (left + right), 0, -0.075 + breath) *
                   about(hipCentre(), turn(0.3 * turned, Vector3d::UnitZ()));
  posture.chest_turn = 0.7 * turned;
  posture.chest_lean = 0.1 + 0.05 * (left + right);
  posture.head_turn = -turned;
  posture.head_lean = -0.05;
  for (const double side : {-1.0, 1.0}) {
    SidePosture& mine = posture.side(side);
    const double out = side > 0 ? left : right;
    mine.foot = side > 0 ? footAt(side, 0.17, 0.02, -0.15) : footAt(side, -0.15, -0.04, -0.6);
    const Vector3d guard(0.19, 0.13 * side, 1.33 + breath), hit(0.57, 0.05 * side, 1.36);
    mine.wrist = guard + out * (hit - guard);
    mine.elbow = Vector3d(-0.25, 0.45 * side, -1);
    mine.thumb = (1 - out) * Vector3d(-0.5, -0.3 * side, 1) + out * Vector3d(0.1, -side, 0.35);
    mine.closed = side > 0 ? closed.at(time) : closed.at(time - 1);
  }
  return posture;
}

Posture hopping(double time) {
  // The pelvis from standing; in flight as everything falls.
  constexpr double g = 9.81, v = 1.98, flight = 2 * v / g, off = 0.9, on = off + flight;
  static const Track height{{0, -kStandingSink}, {0.25, -kStandingSink}, {0.65, -0.24},          {off, 0.01, v, -g},
                            {on, 0.01, -v, -g},  {on + 0.22, -0.2},      {1.75, -kStandingSink}, {1.9, -kStandingSink}};
  static const Track lean{{0, 0.05}, {0.25, 0.05},      {0.65, 0.55}, {off, 0.05},
                          {on, 0.1}, {on + 0.22, 0.45}, {1.75, 0.05}, {1.9, 0.05}};
  static const Track swing{{0, 0.05}, {0.25, 0.05},     {0.65, -0.7}, {off + 0.1, 1.7},
                           {on, 1.1}, {on + 0.25, 0.2}, {1.75, 0.05}, {1.9, 0.05}};
  // How far the heels are raised about the balls of the feet, radians, and how high those are in flight.
  static const Track heel{{0, 0}, {off - 0.14, 0}, {off + 0.05, 0.75}, {on - 0.08, 0.6}, {on + 0.1, 0}, {1.9, 0}};
  const double t = time - 1.9 * std::floor(time / 1.9);
  const double part = (t - off) / flight, aloft = part > 0 && part < 1 ? part * (1 - part) : 0;
  const double lifted = 0.185 * 16 * aloft * aloft;
  Posture posture;
  const double bent = lean.at(t);
  posture.pelvis = pelvisAt(-0.12 * (bent - 0.05), height.at(t), 0.5 * (bent - 0.05));
  posture.chest_lean = 0.6 * bent + 0.02;
  posture.head_lean = -0.6 * (bent - 0.05);
  for (const double side : {-1.0, 1.0}) {
    swingArm(posture, side, swing.at(t));
    const Vector3d ball(rest_pose::ankle(side).x() + 0.16, rest_pose::ankle(side).y(), 0.02);
    posture.side(side).foot = Translation3d(0, 0, lifted) * about(ball, turn(heel.at(t), Vector3d::UnitY()));
  }
  return posture;
}

Posture sitting(double time) {
  static const Track down{{0, 0}, {0.6, 0}, {2.0, 1}, {4.2, 1}, {5.5, 0}, {6, 0}};
  static const Track lean{{0, 0}, {0.5, 0}, {1.3, 0.75}, {2.2, 0.05}, {4.0, 0.05}, {4.7, 0.8}, {5.6, 0}, {6, 0}};
  const double seated = down.at(time), bent = lean.at(time);
  Posture posture;
  posture.pelvis = pelvisAt(-0.37 * seated, -kStandingSink - seated * (0.331 - kStandingSink), 0.35 * bent);
  posture.chest_lean = 0.04 + 0.65 * bent;
  posture.head_lean = -0.5 * bent;
  posture.head_turn = 0.3 * portable::sin(2 * kPi * time / 6);
  for (const double side : {-1.0, 1.0}) {
    SidePosture& mine = posture.side(side);
    swingArm(posture, side, 0.1 + 0.2 * bent);
    const Vector3d on_thigh = Vector3d(-0.12, 0.15 * side, 0.68);
    mine.wrist += seated * (on_thigh - mine.wrist);
    mine.elbow += seated * (Vector3d(-0.5, 0.8 * side, -0.3) - mine.elbow);
    mine.thumb += seated * (Vector3d(0.3, -side, 0.4) - mine.thumb);
    mine.fingers = seated * Vector3d(1, -0.1 * side, -0.15) + (1 - seated) * Vector3d(0.1, 0.1 * side, -1);
  }
  return posture;
}

Posture showingAHand(double time) {
  static const Track turned{{0, -1.4}, {1.5, 1.4}, {3, -1.4}};
  Posture posture;
  posture.pelvis = pelvisAt(0, -kStandingSink, 0);
  posture.head_lean = 0.12;
  posture.head_turn = -0.25;
  swingArm(posture, 1, 0.05 + 0.04 * portable::sin(2 * kPi * time / 3));
  SidePosture& right = posture.side(-1);
  right.wrist = Vector3d(0.42 + 0.02 * portable::sin(4 * kPi * time / 3), -0.185, 1.2);
  right.elbow = Vector3d(-0.2, -0.35, -1);
  right.fingers = Vector3d(0.12, 0, 1);
  right.thumb = turn(turned.at(time), Vector3d(right.fingers.normalized())) * Vector3d::UnitY();
  return posture;
}

namespace {

constexpr double kGravity = 9.81;
constexpr double kTossed = 0.54, kUp = 4.4, kCaught = kTossed + 2 * kUp / kGravity;  // seconds, m/s, seconds
constexpr double kTossPeriod = 2.2;

/** \brief Of the wrist of the hand that tosses. */
double tossingHeight(double time) {
  // The ball leaves the hand, and comes back to it, where both move alike.
  static const Track height{{0, 1.0},
                            {kTossed - 0.127, 0.9},
                            {kTossed, 1.18, kUp, -kGravity},
                            {kTossed + 0.1, 1.4},
                            {kCaught - 0.1, 1.4},
                            {kCaught, 1.18, -kUp, -kGravity},
                            {kCaught + 0.127, 0.9},
                            {1.9, 1.0},
                            {kTossPeriod, 1.0}};
  return height.at(time);
}

}  // namespace

Posture tossing(double time) {
  static const Track gaze{{0, 0.1}, {kTossed, 0}, {kTossed + 0.4, -0.45}, {kCaught, -0.1}, {kTossPeriod, 0.1}};
  Posture posture;
  posture.pelvis = pelvisAt(0, -kStandingSink, 0);
  posture.head_lean = gaze.at(time);
  posture.head_turn = -0.3;
  swingArm(posture, 1, 0.1);
  SidePosture& right = posture.side(-1);
  right.wrist = Vector3d(0.22, -0.22, tossingHeight(time));
  right.elbow = Vector3d(-0.6, -0.3, -1);
  right.fingers = Vector3d::UnitX();
  right.thumb = -Vector3d::UnitY();  // the palm is up
  right.closed = 0.08;
  return posture;
}

Isometry3d tossedBall(double time) {
  static const Track turned{{0, 0}, {kTossed, 0}, {kCaught, 2 * kPi}, {kTossPeriod, 2 * kPi}};
  const double t = time - kTossPeriod * std::floor(time / kTossPeriod), s = t - kTossed;
  const bool aloft = t > kTossed && t < kCaught;
  const double wrist = aloft ? 1.18 + kUp * s - 0.5 * kGravity * s * s : tossingHeight(t);
  constexpr double half_palm = 0.0235;
  Isometry3d T = Isometry3d::Identity();
  T.translate(Vector3d(0.22 + 0.075, -0.22, wrist + half_palm + kBallRadius));
  T.rotate(turn(turned.at(t), Vector3d::UnitY()));
  return T;
}

double twist(double time) {
  static const Track angle{{0, -0.75}, {0.8, 0.75}, {1.6, -0.75}};
  return angle.at(time);
}

Posture twisting(double time) {
  Posture posture;
  const double turned = twist(time);
  posture.pelvis = pelvisAt(0, -0.05, 0) * about(hipCentre(), turn(turned, Vector3d::UnitZ()));
  posture.chest_turn = 0.35 * twist(time + 0.1);
  posture.chest_lean = 0.02;
  posture.head_turn = -0.5 * turned;
  for (const double side : {-1.0, 1.0}) {
    SidePosture& mine = posture.side(side);
    mine.foot = footAt(side, 0, 0.03 * side, 0.25 * side);
    const Isometry3d chest = chestOf(posture);
    mine.wrist = chest * Vector3d(rest_pose::shoulder(side) + Vector3d(0.1, 0.46 * side, 0.1));
    mine.elbow = chest.linear() * Vector3d(-0.4, 0, -1);
    mine.thumb = chest.linear() * Vector3d(1, 0, 0.4);
    mine.closed = 0.1;
  }
  return posture;
}

Posture shakingHands(double time) {
  static const Track raised{{0, 0}, {0.2, 0}, {0.9, 1}, {2.7, 1}, {3.4, 0}, {4, 0}};
  static const Track shaken{{0, 0},       {1.0, 0},    {1.2, 0.04},  {1.4, -0.04}, {1.6, 0.04},
                            {1.8, -0.04}, {2.0, 0.04}, {2.2, -0.02}, {2.5, 0},     {4, 0}};
  const double up = raised.at(time);
  Posture posture;
  posture.pelvis = pelvisAt(0, -kStandingSink, 0.05 * up);
  posture.chest_turn = 0.2 * up;
  posture.chest_lean = 0.04 + 0.08 * up;
  posture.head_turn = -0.15 * up;
  swingArm(posture, 1, 0.05);
  swingArm(posture, -1, 0.05);
  SidePosture& right = posture.side(-1);
  // Palm on palm: half a hand beside the middle between both people. Wrists are two thirds of a hand from it.
  const Vector3d met(0.45 - 0.075, -0.018, 1.0 + shaken.at(time));
  right.wrist += up * (met - right.wrist);
  right.elbow += up * (Vector3d(-0.5, -0.5, -1) - right.elbow);
  right.thumb += up * (Vector3d::UnitZ() - right.thumb);
  right.fingers = up * Vector3d::UnitX() + (1 - up) * Vector3d(0.1, -0.1, -1);
  right.closed = 0.25 * (1 - up);
  return posture;
}

}  // namespace fuse_flow::simulation
