#include "point_arrays.h"

#include <cstring>
#include <string>

namespace fuse_flow::python {
namespace {

namespace py = pybind11;

template <typename T>
using Rows = py::array_t<T, py::array::c_style | py::array::forcecast>;

py::array toArray(const py::object& object) {
  return py::array::ensure(py::module_::import("numpy").attr("asarray")(object));
}

std::string describedPoints(const py::array& array) {
  return std::string(py::str(array.dtype())) + " of shape " + std::string(py::str(array.attr("shape")));
}

}  // namespace

py::array_t<float> tripletsOf(const py::object& object, const char* what) {
  const py::array array = toArray(object);
  if (array.ndim() != 2 || array.shape(1) != 3 || array.dtype().kind() != 'f')
    throw py::value_error("fuse_flow: " + std::string(what) + " is " + describedPoints(array) +
                          ", must be float32 or float64 of shape (N, 3)");
  return Rows<float>::ensure(array);
}

pcl::PointCloud<pcl::PointXYZ> cloudOf(const py::object& points) {
  pcl::PointCloud<pcl::PointXYZ> cloud;
  if (py::isinstance<Cloud>(points)) {
    const auto& fused = py::cast<const Cloud&>(points);
    cloud.resize(fused.size);
    for (std::size_t i = 0; i < fused.size; ++i)
      std::memcpy(cloud[i].data, fused.points + i * fused.layout.size, 3 * sizeof(float));
    return cloud;
  }
  const py::array_t<float> array = tripletsOf(points, "points");
  cloud.resize(static_cast<std::size_t>(array.shape(0)));
  for (std::size_t i = 0; i < cloud.size(); ++i) std::memcpy(cloud[i].data, array.data() + 3 * i, 3 * sizeof(float));
  return cloud;
}

template <typename T>
py::array_t<T> numbersOf(const py::object& object, const char* what, std::size_t points) {
  const py::array array = toArray(object);
  const bool floats = array.dtype().kind() == 'f', wanted = std::is_floating_point_v<T>;
  const bool integers = array.dtype().kind() == 'u' || array.dtype().kind() == 'i';
  if (array.ndim() != 1 || static_cast<std::size_t>(array.shape(0)) != points || !(wanted ? floats : integers))
    throw py::value_error("fuse_flow: " + std::string(what) + " is " + describedPoints(array) + ", must be " +
                          (wanted ? "floats" : "integers") + " of shape (" + std::to_string(points) + ",)");
  return Rows<T>::ensure(array);
}

template py::array_t<float> numbersOf<float>(const py::object&, const char*, std::size_t);
template py::array_t<std::uint32_t> numbersOf<std::uint32_t>(const py::object&, const char*, std::size_t);

}  // namespace fuse_flow::python
