#pragma once

#include "simulation/scenes/person_skeleton.h"

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

}  // namespace fuse_flow::simulation
