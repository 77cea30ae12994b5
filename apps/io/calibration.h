#pragma once

#include <fuse_flow/camera.h>

#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief Sixteen numbers, row by row, as a pose. Throws InputError, beginning with owner, unless it is finite, its
 *  last row is 0 0 0 1, and its rotation is orthonormal to 1e-3 with determinant +1. */
Eigen::Isometry3d rigidPose(const std::string& owner, const std::vector<double>& row_major);

/** \brief All numbers of a text file, separated by white space; comments start with #. Throws InputError, naming the
 *  word that is no number. */
std::vector<double> readNumbers(const std::string& path);

/** \brief A pose as it stands in one text file: 4×4, row by row. */
Eigen::Isometry3d readPose(const std::string& path);

/** \brief The message of checkCamera() as an InputError that begins with owner. */
void checkCameraInput(const std::string& owner, const Camera& camera);

}  // namespace fuse_flow::io
