#include "poses.h"

#include <fuse_flow/camera.h>

#include <string>

namespace fuse_flow::python {
namespace {

namespace py = pybind11;

using Matrices = py::array_t<double, py::array::c_style | py::array::forcecast>;

std::string shapeOf(const py::array& array) { return py::str(array.attr("shape")); }

Eigen::Isometry3d poseAt(const double* numbers, const char* what) {
  Eigen::Isometry3d pose;
  pose.matrix() = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(numbers);
  if (pose.matrix().row(3) != Eigen::RowVector4d(0, 0, 0, 1))
    throw py::value_error(std::string(what) + ": the last row must be 0 0 0 1");
  const std::string nobody;
  detail::checkPose({"fuse_flow", nobody, ""}, what, pose);
  return pose;
}

Matrices toMatrices(const py::object& object, const char* what) {
  Matrices array = Matrices::ensure(object);
  if (array) return array;
  PyErr_Clear();
  throw py::value_error(std::string(what) + " must be numbers in an array of shape (4, 4)");
}

}  // namespace

Eigen::Isometry3d poseOf(const py::object& matrix, const char* what) {
  const Matrices array = toMatrices(matrix, what);
  if (array.ndim() != 2 || array.shape(0) != 4 || array.shape(1) != 4)
    throw py::value_error(std::string(what) + " is of shape " + shapeOf(array) + ", must be (4, 4)");
  return poseAt(array.data(), what);
}

std::vector<Eigen::Isometry3d> posesOf(const py::object& matrices, const char* what) {
  const Matrices array = toMatrices(matrices, what);
  if (array.ndim() != 3 || array.shape(1) != 4 || array.shape(2) != 4)
    throw py::value_error(std::string(what) + " is of shape " + shapeOf(array) +
                          ", must be (N, 4, 4): one matrix for each camera");
  std::vector<Eigen::Isometry3d> poses;
  for (py::ssize_t i = 0; i < array.shape(0); ++i) poses.push_back(poseAt(array.data() + 16 * i, what));
  return poses;
}

py::array readOnly(py::array array) {
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

py::array matricesOf(const std::vector<Eigen::Isometry3d>& poses) {
  Matrices array(std::vector<py::ssize_t>{static_cast<py::ssize_t>(poses.size()), 4, 4});
  for (std::size_t i = 0; i < poses.size(); ++i)
    Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(array.mutable_data() + 16 * i) = poses[i].matrix();
  return readOnly(std::move(array));
}

py::array matrixOf(const Eigen::Isometry3d& pose) { return readOnly(matricesOf({pose}).attr("__getitem__")(0)); }

}  // namespace fuse_flow::python
