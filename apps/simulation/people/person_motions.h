#pragma once

#include "simulation/people/person_skeleton.h"

/** \file
 *  \brief What a person does at a place, over and over; facing x, the rest pose's feet beside the origin. */

namespace fuse_flow::simulation {

/** \brief Punches with the left and the right hand in turn, first as a fist, then open: each out within a tenth of a second, the
 *  hand at up to 7.5 m/s. Every 4 s the same. */
Posture punching(double time);

/** \brief Hops 20 cm high, the arms swinging up. Every 1.9 s the same. */
Posture hopping(double time);

/** \brief Sits down on a chair 0.47 m high whose front edge is at x = −0.29, stays and rises. Every 6 s the same. */
Posture sitting(double time);

/** \brief Holds up the right hand at (0.42, −0.185, 1.2), fingers spread, and turns it to the left and to the right. Every 3 s the
 *  same. */
Posture showingAHand(double time);

/** \brief Tosses a ball 1 m up and catches it. Every 2.2 s the same. */
Posture tossing(double time);

constexpr double kBallRadius = 0.06;  // metres

/** \brief The ball of tossing(): in the right hand, or falling freely; it turns once in the air. */
Eigen::Isometry3d tossedBall(double time);

/** \brief Turns to the left and to the right on feet that stand, arms stretched out. Every 1.6 s the same. */
Posture twisting(double time);

/** \brief How far the pelvis is turned then, radians. */
double twist(double time);

/** \brief Shakes the right hand of somebody who stands 0.9 m in front and does the same. Every 4 s the same. */
Posture shakingHands(double time);

}  // namespace fuse_flow::simulation
