#include "bindings.h"
#include "calibration/poses.h"
#include "plain.h"

#include <fuse_flow/camera.h>

#include <pybind11/stl.h>

#include <algorithm>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

namespace fuse_flow::python {
namespace {

namespace py = pybind11;

using Knots = py::array_t<float, py::array::c_style | py::array::forcecast>;

py::array knotsOf(const DepthCorrection& correction, const std::vector<float>& values) {
  const std::vector<py::ssize_t> shape{correction.rows, correction.columns};
  Knots knots(shape);
  std::copy(values.begin(), values.end(), knots.mutable_data());
  return readOnly(std::move(knots));
}

DepthCorrection correctionOf(const Knots& relative, const Knots& per_metre) {
  if (relative.ndim() != 2 || per_metre.ndim() != 2 || relative.shape(0) != per_metre.shape(0) ||
      relative.shape(1) != per_metre.shape(1))
    throw py::value_error(
        "fuse_flow.DepthCorrection: relative and per_metre must be arrays of one shape, (rows, columns)");
  DepthCorrection correction;
  correction.rows = static_cast<int>(relative.shape(0));
  correction.columns = static_cast<int>(relative.shape(1));
  correction.relative.assign(relative.data(), relative.data() + relative.size());
  correction.per_metre.assign(per_metre.data(), per_metre.data() + per_metre.size());
  return correction;
}

Distortion distortionOf(const std::vector<float>& k) {
  Distortion d;
  float* numbers[] = {&d.k1, &d.k2, &d.p1, &d.p2, &d.k3, &d.k4, &d.k5, &d.k6};
  if (k.size() > 8)
    throw py::value_error("fuse_flow.Distortion has 8 coefficients at most, k1 k2 p1 p2 k3 k4 k5 k6, not " +
                          std::to_string(k.size()));
  for (std::size_t i = 0; i < k.size(); ++i) *numbers[i] = k[i];
  return d;
}

std::string describeIntrinsics(const Intrinsics& K) {
  std::ostringstream text;
  text << "Intrinsics(width=" << K.width << ", height=" << K.height << ", fx=" << K.fx << ", fy=" << K.fy
       << ", cx=" << K.cx << ", cy=" << K.cy << (isIdeal(K.distortion) ? ")" : ", distortion=…)");
  return text.str();
}

void bindIntrinsics(py::module_& module) {
  auto distortion = named<Distortion>(module, "Distortion");
  plain(distortion)
      .def(py::init(&distortionOf), py::arg("coefficients"),
           "From k1, k2, p1, p2, k3, k4, k5, k6 in this order, which is OpenCV's; those left out are 0.")
      .FUSE_FLOW_FIELD(Distortion, k1)
      .FUSE_FLOW_FIELD(Distortion, k2)
      .FUSE_FLOW_FIELD(Distortion, p1)
      .FUSE_FLOW_FIELD(Distortion, p2)
      .FUSE_FLOW_FIELD(Distortion, k3)
      .FUSE_FLOW_FIELD(Distortion, k4)
      .FUSE_FLOW_FIELD(Distortion, k5)
      .FUSE_FLOW_FIELD(Distortion, k6);

  auto intrinsics = named<Intrinsics>(module, "Intrinsics");
  intrinsics
      .def(py::init([](int width, int height, float fx, float fy, float cx, float cy, const Distortion& d) {
             return Intrinsics{width, height, fx, fy, cx, cy, d};
           }),
           py::arg("width"), py::arg("height"), py::arg("fx"), py::arg("fy"), py::arg("cx"), py::arg("cy"),
           py::arg("distortion") = Distortion())
      .def("__repr__", &describeIntrinsics)
      .FUSE_FLOW_FIELD(Intrinsics, width)
      .FUSE_FLOW_FIELD(Intrinsics, height)
      .FUSE_FLOW_FIELD(Intrinsics, fx)
      .FUSE_FLOW_FIELD(Intrinsics, fy)
      .FUSE_FLOW_FIELD(Intrinsics, cx)
      .FUSE_FLOW_FIELD(Intrinsics, cy)
      .FUSE_FLOW_FIELD(Intrinsics, distortion);
  plain(intrinsics);
}

void bindSensor(py::module_& module) {
  auto noise = named<NoiseModel>(module, "NoiseModel");
  plain(noise)
      .FUSE_FLOW_FIELD(NoiseModel, floor)
      .FUSE_FLOW_FIELD(NoiseModel, linear)
      .FUSE_FLOW_FIELD(NoiseModel, quadratic)
      .def_static("stereo", &NoiseModel::stereo, py::arg("focal_length"), py::arg("baseline"),
                  py::arg("disparity_deviation"), py::arg("floor") = 0.0005f, doc("NoiseModel::stereo"));

  auto multipath = named<Multipath>(module, "Multipath");
  plain(multipath).FUSE_FLOW_FIELD(Multipath, modulation_frequency).FUSE_FLOW_FIELD(Multipath, reflectance);

  named<DepthCorrection>(module, "DepthCorrection")
      .def(py::init<>())
      .def(py::init(&correctionOf), py::arg("relative"), py::arg("per_metre"),
           "From the knots, two arrays of shape (rows, columns), 2 to 64 each way; -0.5 … 0.5.")
      .FUSE_FLOW_RESULT(DepthCorrection, columns)
      .FUSE_FLOW_RESULT(DepthCorrection, rows)
      .def_property_readonly(
          "relative", [](const DepthCorrection& c) { return knotsOf(c, c.relative); }, doc("DepthCorrection::relative"))
      .def_property_readonly(
          "per_metre", [](const DepthCorrection& c) { return knotsOf(c, c.per_metre); },
          doc("DepthCorrection::per_metre"));

  auto color = named<ColorCamera>(module, "ColorCamera");
  plain(color)
      .FUSE_FLOW_FIELD(ColorCamera, intrinsics)
      .def_property(
          "T_depth_color", [](const ColorCamera& c) { return matrixOf(c.T_depth_color); },
          [](ColorCamera& c, const py::object& matrix) { c.T_depth_color = poseOf(matrix, "T_depth_color"); },
          doc("ColorCamera::T_depth_color"));
}

}  // namespace

void bindCameras(py::module_& module) {
  bindIntrinsics(module);
  bindSensor(module);
  auto camera = named<Camera>(module, "Camera");
  camera
      .def(py::init(
               [](const Intrinsics& intrinsics, const py::object& pose, const std::string& name, float depth_scale) {
                 Camera made;
                 made.name = name;
                 made.intrinsics = intrinsics;
                 made.depth_scale = depth_scale;
                 if (!pose.is_none()) made.T_world_camera = poseOf(pose, "T_world_camera");
                 return made;
               }),
           py::arg("intrinsics"), py::arg("T_world_camera") = py::none(), py::arg("name") = "",
           py::arg("depth_scale") = Camera().depth_scale,
           "T_world_camera: 4×4, camera to world, metres; default the identity. depth_scale: metres per unit of uint16 "
           "depth.")
      .FUSE_FLOW_FIELD(Camera, name)
      .FUSE_FLOW_FIELD(Camera, intrinsics)
      .FUSE_FLOW_FIELD(Camera, depth_scale)
      .FUSE_FLOW_FIELD(Camera, depth_correction)
      .FUSE_FLOW_FIELD(Camera, multipath)
      .def_property(
          "T_world_camera", [](const Camera& c) { return matrixOf(c.T_world_camera); },
          [](Camera& c, const py::object& matrix) { c.T_world_camera = poseOf(matrix, "T_world_camera"); },
          doc("Camera::T_world_camera"))
      // By pointer, so that what is written into them is not lost in a copy.
      .def_property(
          "color",
          py::cpp_function([](Camera& c) { return c.color ? &*c.color : nullptr; },
                           py::return_value_policy::reference_internal),
          [](Camera& c, const std::optional<ColorCamera>& color) { c.color = color; }, doc("Camera::color"))
      .def_property(
          "noise",
          py::cpp_function([](Camera& c) { return c.noise ? &*c.noise : nullptr; },
                           py::return_value_policy::reference_internal),
          [](Camera& c, const std::optional<NoiseModel>& noise) { c.noise = noise; }, doc("Camera::noise"))
      .def("check", &checkCamera,
           "Raises ValueError, naming the camera and the value, if the camera contradicts itself.")
      .def("__repr__",
           [](const Camera& c) { return "Camera(" + describeIntrinsics(c.intrinsics) + ", name='" + c.name + "')"; });
  plain(camera);
}

}  // namespace fuse_flow::python
