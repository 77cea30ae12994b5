#pragma once

#include <fuse_flow/camera.h>

#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief Sixteen numbers, row by row, as a pose. Throws InputError, beginning with owner, unless it is finite, its
 *  last row is 0 0 0 1, and its rotation is orthonormal to 1e-3 with determinant +1. */
Eigen::Isometry3d rigidPose(const std::string& owner, const std::vector<double>& row_major);

/** \brief The same of a pose that was printed with few digits: a rotation that is orthonormal to 0.01 becomes the nearest that is one. */
Eigen::Isometry3d nearlyRigidPose(const std::string& owner, const std::vector<double>& row_major);

/** \brief A 3×3 matrix of intrinsics, row by row, whose width and height stay 0. Throws InputError unless it is one. */
Intrinsics intrinsicsOf(const std::string& owner, const std::vector<double>& row_major);

/** \brief A number of pixels; 0 where it is left out. Throws InputError for what is none. \param key what messages call it */
int imageSide(const std::string& path, const char* key, double value);

/** \brief k1 k2 p1 p2 [k3 [k4 k5 k6]], the order of OpenCV and ROS. Throws InputError for another number of coefficients. */
Distortion distortionOf(const std::string& path, const std::vector<double>& k);

/** \brief All numbers of a text file, separated by white space; comments start with #. Throws InputError, naming the
 *  word that is no number. */
std::vector<double> readNumbers(const std::string& path);

/** \brief A pose as it stands in one text file: 4×4, row by row. */
Eigen::Isometry3d readPose(const std::string& path);

/** \brief Throws InputError for a 3×3 matrix of intrinsics whose pixels are no rectangles. \param skew its first row's second number
 *  \param fx pixels */
void checkSkew(const std::string& owner, double skew, double fx);

/** \brief Throws InputError, beginning with owner, for a camera that checkCamera() refuses or that no lens is like: far out, with a focal
 *  length under a thousandth or over a thousand times its image, an optical axis more than ten images outside, distortion over
 *  100,000. */
void checkCameraInput(const std::string& owner, const Camera& camera);

}  // namespace fuse_flow::io
