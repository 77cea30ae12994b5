#pragma once

#include "simulation/surfaces/mesh.h"

#include <Eigen/Geometry>

namespace fuse_flow::simulation {

/** \brief AprilTag 0 of the family 36h11 on a white plate that someone waves about the subject: once around in 3.3 s, upright and
 *  nodding. \param side of its black square, metres  \param time seconds */
Object makeMarker(double side, const Eigen::AlignedBox3f& subject, double time);

}  // namespace fuse_flow::simulation
