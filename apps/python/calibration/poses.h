#pragma once

#include <pybind11/numpy.h>

#include <Eigen/Geometry>

#include <vector>

namespace fuse_flow::python {

/** \brief A pose from anything that numpy makes a 4×4 matrix of. \param what its name in messages
 *  \throws pybind11::value_error for another shape, another last row than 0 0 0 1, or a rotation that is none */
Eigen::Isometry3d poseOf(const pybind11::object& matrix, const char* what);
/** \brief One pose for each camera: a sequence of matrices, or an array of shape (N, 4, 4). */
std::vector<Eigen::Isometry3d> posesOf(const pybind11::object& matrices, const char* what);

/** \brief A pose as a 4×4 array of float64. It is a copy, and read-only, so that nobody writes into it and wonders why nothing moves. */
pybind11::array matrixOf(const Eigen::Isometry3d& pose);
/** \brief Poses as one read-only array of shape (N, 4, 4). */
pybind11::array matricesOf(const std::vector<Eigen::Isometry3d>& poses);

/** \brief The same array, read-only. */
pybind11::array readOnly(pybind11::array array);

}  // namespace fuse_flow::python
