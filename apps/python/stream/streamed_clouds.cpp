#include "../plain.h"
#include "streams.h"

#include <pybind11/numpy.h>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace fuse_flow::python {
namespace {

namespace py = pybind11;

/** \brief An array of what was received; None if the stream does not carry it. */
template <typename T>
py::object arrayIn(const Received& cloud, const std::vector<T>& values, py::ssize_t length) {
  if (values.empty() && cloud->size() > 0) return py::none();
  const py::capsule owner(new Received(cloud), [](void* kept) { delete static_cast<Received*>(kept); });
  std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(cloud->size())};
  if (length > 0) shape.push_back(length);
  return py::array(py::dtype::of<T>(), shape, {}, values.data(), owner);
}

py::object confidenceIn(const Received& cloud) {
  if (cloud->confidence.empty() && cloud->size() > 0) return py::none();
  py::array_t<float> confidence(static_cast<py::ssize_t>(cloud->size()));
  std::transform(cloud->confidence.begin(), cloud->confidence.end(), confidence.mutable_data(),
                 [](std::uint8_t c) { return static_cast<float>(c) / 255.0f; });
  return confidence;
}

/** \brief Bit k is that of word k / 32, in the byte order of this machine, which streams have too. */
py::object camerasIn(const Received& cloud) {
  if (cloud->camera_masks.empty() && cloud->size() > 0) return py::none();
  static_assert(sizeof(cloud->camera_masks[0]) == 2 * sizeof(std::uint32_t));
  const py::capsule owner(new Received(cloud), [](void* kept) { delete static_cast<Received*>(kept); });
  const std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(cloud->size()), 2};
  return py::array(py::dtype::of<std::uint32_t>(), shape, {}, cloud->camera_masks.data(), owner);
}

}  // namespace

void bindStreamedClouds(py::module_& module) {
  py::class_<stream::StreamedCloud, Received>(module, "StreamedCloud",
                                              "A cloud as it arrived. Its arrays are not copied.")
      .def("__len__", &stream::StreamedCloud::size)
      .def_property_readonly(
          "points", [](const Received& c) { return arrayIn(c, c->positions, 3); },
          "(N, 3) float32: x, y, z in the world frame, metres; off by at most half of step.")
      .def_property_readonly(
          "colors", [](const Received& c) { return arrayIn(c, c->colors, 3); },
          "(N, 3) uint8: red, green, blue; None if the stream has none.")
      .def_property_readonly("confidence", &confidenceIn,
                             "(N,) float32, 0 … 1, in steps of 1/255; None if the stream has none.")
      .def_property_readonly(
          "view_count", [](const Received& c) { return arrayIn(c, c->view_counts, 0); },
          "(N,) uint8: the number of cameras that contributed; None if the stream has none.")
      .def_property_readonly(
          "normals", [](const Received& c) { return arrayIn(c, c->normals, 3); },
          "(N, 3) float32; 0, 0, 0 where none is known; None if the stream has none.")
      .def_property_readonly("camera_mask", &camerasIn,
                             "(N, 2) uint32, as Cloud.camera_mask; None if the stream has none.")
      .def_property_readonly(
          "step", [](const Received& c) { return c->step; }, doc("StreamedCloud::step"))
      .def_property_readonly(
          "points_of_frame", [](const Received& c) { return c->points_of_frame; },
          doc("StreamedCloud::points_of_frame"))
      .def_property_readonly(
          "number", [](const Received& c) { return c->times.number; }, "As it was published.")
      .def_property_readonly(
          "captured", [](const Received& c) { return c->times.captured; }, doc("FrameTimes::captured"))
      .def_property_readonly(
          "encoded", [](const Received& c) { return c->times.encoded; },
          "When it became bytes, nanoseconds since 1970 by the server's clock; 0: not known.");
}

}  // namespace fuse_flow::python
