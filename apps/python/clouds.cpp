#include "bindings.h"
#include "cloud.h"
#include "docstrings.h"

#include <pybind11/numpy.h>

#include <string>
#include <vector>

namespace fuse_flow::python {
namespace {

namespace py = pybind11;

/** \brief A field of all points as an array, which keeps the cloud. \param offset of the field, bytes  \param length of a vector; 0: a number
 *  \param step between the elements of the vector, bytes */
template <typename T>
py::array fieldOf(const py::object& self, std::size_t offset, py::ssize_t length = 0, py::ssize_t step = sizeof(T)) {
  const auto& cloud = py::cast<const Cloud&>(self);
  std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(cloud.size)};
  std::vector<py::ssize_t> strides{static_cast<py::ssize_t>(cloud.layout.size)};
  if (length > 0) {
    shape.push_back(length);
    strides.push_back(step);
  }
  if (cloud.size == 0) return py::array(py::dtype::of<T>(), shape);
  return py::array(py::dtype::of<T>(), shape, strides, cloud.points + offset, self);
}

py::dtype typeOf(const PointLayout& layout) {
  py::list names, formats, offsets;
  const auto add = [&](const char* name, const char* format, std::size_t offset) {
    names.append(name);
    formats.append(format);
    offsets.append(offset);
  };
  add("x", "=f4", 0);
  add("y", "=f4", 4);
  add("z", "=f4", 8);
  if (layout.normal) {
    add("normal_x", "=f4", *layout.normal);
    add("normal_y", "=f4", *layout.normal + 4);
    add("normal_z", "=f4", *layout.normal + 8);
  }
  add("rgba", "=u4", layout.rgba);
  add("confidence", "=f4", layout.confidence);
  add("view_count", "=u4", layout.view_count);
  if (layout.camera_mask) add("camera_mask", "(2,)=u4", *layout.camera_mask);
  return {names, formats, offsets, static_cast<py::ssize_t>(layout.size)};
}

py::array structured(const py::object& self) {
  const auto& cloud = py::cast<const Cloud&>(self);
  const std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(cloud.size)};
  if (cloud.size == 0) return py::array(typeOf(cloud.layout), shape);
  return py::array(typeOf(cloud.layout), shape, {static_cast<py::ssize_t>(cloud.layout.size)}, cloud.points, self);
}

const PointLayout& layoutIn(const py::object& self) { return py::cast<const Cloud&>(self).layout; }

py::object optionalField(const py::object& self, const std::optional<std::size_t>& offset, const char* how,
                         py::array (*field)(const py::object&, std::size_t)) {
  if (!offset) throw py::attribute_error(how);
  return field(self, *offset);
}

}  // namespace

void bindClouds(py::module_& module) {
  py::class_<Cloud>(
      module, "Cloud",
      "A fused cloud. Its arrays are views of C++'s memory, which they keep: nothing is copied. Who writes into one "
      "changes the cloud.")
      .def("__len__", [](const Cloud& cloud) { return cloud.size; })
      .def("__repr__", [](const Cloud& cloud) { return "Cloud of " + std::to_string(cloud.size) + " points"; })
      .def_property_readonly(
          "points", [](const py::object& self) { return fieldOf<float>(self, 0, 3); },
          "(N, 3) float32: x, y, z in the world frame, metres.")
      // PCL packs blue, green, red, alpha.
      .def_property_readonly(
          "colors", [](const py::object& self) { return fieldOf<std::uint8_t>(self, layoutIn(self).rgba + 2, 3, -1); },
          "(N, 3) uint8: red, green, blue; black without colour images. PyTorch wants a copy of it, as its strides are "
          "negative.")
      .def_property_readonly(
          "confidence", [](const py::object& self) { return fieldOf<float>(self, layoutIn(self).confidence); },
          (std::string("(N,) float32: ") + doc("PointFused::confidence")).c_str())
      .def_property_readonly(
          "view_count", [](const py::object& self) { return fieldOf<std::uint32_t>(self, layoutIn(self).view_count); },
          "(N,) uint32: the number of cameras that contributed.")
      .def_property_readonly(
          "normals",
          [](const py::object& self) {
            return optionalField(
                self, layoutIn(self).normal, "this cloud has no normals: FuseFlow(normals=True) makes them",
                [](const py::object& cloud, std::size_t offset) { return fieldOf<float>(cloud, offset, 3); });
          },
          "(N, 3) float32, of length 1, facing the cameras; NaN where none is known. Only of FuseFlow(normals=True).")
      .def_property_readonly(
          "camera_mask",
          [](const py::object& self) {
            return optionalField(
                self, layoutIn(self).camera_mask, "this cloud has no camera_mask: FuseFlow(camera_mask=True) makes it",
                [](const py::object& cloud, std::size_t offset) { return fieldOf<std::uint32_t>(cloud, offset, 2); });
          },
          (std::string("(N, 2) uint32. ") + doc("PointFusedCameras::camera_mask") +
           " Only of FuseFlow(camera_mask=True).")
              .c_str())
      .def_property_readonly(
          "array", &structured,
          "(N,) structured, with the names of C++'s point: x, y, z, rgba, confidence, view_count, and what was "
          "asked for.")
      .def_readonly("stamp", &Cloud::stamp, "Of the frame that it was fused from, microseconds.");
}

}  // namespace fuse_flow::python
