#pragma once

/** \file
 *  \brief Errors of poses by wrong depth, independent of the search for correspondences. */

#include "simulation/simulator.h"

#include <Eigen/Geometry>

#include <cstddef>
#include <vector>

namespace bench {

/** \brief Poses of least squares with everything known but the noise: which pixels see the same place, by the true surfaces and poses; its
 *  true normal; the sensor's own noise model for weights; and no error of linearising. What is left is what depth was measured wrong.
 *  \param frames of one rig that does not move  \param stride every so many-th pixel, each way */
std::vector<Eigen::Isometry3d> posesOfExactCorrespondences(fuse_flow::simulation::Simulator& simulator,
                                                           std::size_t frames, int stride);

}  // namespace bench
