#include "frames.h"

#include "bindings.h"
#include "garbage.h"
#include "images.h"
#include "plain.h"

#include <string>
#include <utility>
#include <vector>

namespace fuse_flow::python {
namespace {

namespace py = pybind11;

py::object imageOf(const py::object& object) {
  if (object.is_none() || (!py::isinstance<py::array>(object) && onDevice(object))) return object;
  return arrayOf(object);
}

/** \brief What imageOf() has let in, as an array. */
py::array asArray(const py::object& object, const char* what, std::vector<py::object>& kept, DeviceReader* reader) {
  if (!py::isinstance<py::array>(object)) {
    if (reader == nullptr)
      throw py::value_error("fuse_flow.DepthView: " + std::string(what) +
                            " is in the memory of a GPU: FuseFlow(device='gpu') reads it there, nothing else does");
    kept.push_back(addressesOf(object, what, *reader));
    return py::reinterpret_borrow<py::array>(kept.back());
  }
  kept.push_back(object);
  return py::reinterpret_borrow<py::array>(object);
}

/** \brief Whether all arrays fit, wherever they are. */
void checkImages(const ViewArrays& arrays) {
  std::vector<py::object> kept;
  DeviceReader anywhere{-1, 0, {}};
  arrays.view(kept, &anywhere);
}

/** \brief Checks an array as it is set, so that what is wrong is said where it happens. */
void setImage(ViewArrays& arrays, py::object ViewArrays::*member, const py::object& value) {
  const py::object before = std::exchange(arrays.*member, imageOf(value));
  try {
    checkImages(arrays);
  } catch (...) {
    arrays.*member = before;
    throw;
  }
}

std::string typeOf(const py::handle& object) { return py::str(py::type::handle_of(object).attr("__name__")); }

template <typename T>
const T& elementOf(const py::handle& element, const char* list, std::size_t i, const char* right) {
  if (!py::isinstance<T>(element))
    throw py::type_error("fuse_flow.RigFrame: " + std::string(list) + "[" + std::to_string(i) + "] is " +
                         typeOf(element) + ", must be " + right);
  return py::cast<const T&>(element);
}

constexpr const char* kCamera = "a Camera";
constexpr const char* kView = "a DepthView, or None for a camera that is missing";

/** \brief Whether the lists have what a frame is made of; whether it fits, fuse() finds out. */
void checkElements(const FrameLists& lists) {
  std::size_t i = 0;
  for (const py::handle camera : lists.cameras) elementOf<Camera>(camera, "cameras", i++, kCamera);
  i = 0;
  for (const py::handle view : lists.views) {
    if (!view.is_none()) elementOf<ViewArrays>(view, "views", i, kView);
    ++i;
  }
}

py::list listOf(const py::object& sequence, const char* what) {
  if (!py::isinstance<py::iterable>(sequence))
    throw py::type_error("fuse_flow.RigFrame: " + std::string(what) + " is " + typeOf(sequence) + ", must be a list");
  if (py::isinstance<py::list>(sequence)) return py::reinterpret_borrow<py::list>(sequence);
  return py::list(sequence);
}

std::string describeFrame(const FrameLists& lists) {
  return "RigFrame of " + std::to_string(py::len(lists.cameras)) + " cameras, stamp " + std::to_string(lists.stamp);
}

}  // namespace

DepthView ViewArrays::view(std::vector<py::object>& kept, DeviceReader* reader) const {
  DepthView view;
  if (!depth.is_none()) setDepth(asArray(depth, "depth", kept, reader), view);
  if (!color.is_none()) view.color = colorImageOf(asArray(color, "color", kept, reader));
  if (!confidence.is_none())
    view.confidence = floatImageOf(asArray(confidence, "confidence", kept, reader), "confidence");
  return view;
}

void FrameInput::fill(const FrameLists& lists, DeviceReader* reader) {
  kept_.clear();
  frame.stamp = lists.stamp;
  frame.cameras.resize(py::len(lists.cameras));
  frame.views.assign(py::len(lists.views), {});
  std::size_t i = 0;
  for (const py::handle camera : lists.cameras) {
    if (i == frame.cameras.size()) break;
    frame.cameras[i] = elementOf<Camera>(camera, "cameras", i, kCamera);
    ++i;
  }
  i = 0;
  for (const py::handle element : lists.views) {
    if (i == frame.views.size()) break;
    if (!element.is_none()) {
      frame.views[i] = elementOf<ViewArrays>(element, "views", i, kView).view(kept_, reader);
    }
    ++i;
  }
}

RigFrame FrameInput::named() const {
  RigFrame result = frame;
  for (std::size_t i = 0; i < result.cameras.size(); ++i)
    if (result.cameras[i].name.empty()) result.cameras[i].name = std::to_string(i);
  return result;
}

void bindFrames(py::module_& module) {
  py::class_<ViewArrays>(
      module, "DepthView",
      "What one camera measured at one instant: arrays, which are not copied.\n\n"
      "They may be numpy arrays, read-only too, whatever numpy makes one of without a copy, or, for "
      "FuseFlow(device='gpu'), "
      "tensors of a GPU that know DLPack or __cuda_array_interface__. Rows may be any "
      "number of bytes apart. 0, 65535, NaN and ±inf mean \"no measurement\". Without depth the camera is missing "
      "from this frame, which is not an error.",
      collected<ViewArrays>())
      .def(py::init([](const py::object& depth, const py::object& color, const py::object& confidence) {
             ViewArrays arrays{imageOf(depth), imageOf(color), imageOf(confidence)};
             checkImages(arrays);
             return arrays;
           }),
           py::arg("depth") = py::none(), py::arg("color") = py::none(), py::arg("confidence") = py::none())
      .def_property(
          "depth", [](const ViewArrays& arrays) { return arrays.depth; },
          [](ViewArrays& arrays, const py::object& value) { setImage(arrays, &ViewArrays::depth, value); },
          "(height, width): uint16 in units of Camera.depth_scale, or float32 in metres.")
      .def_property(
          "color", [](const ViewArrays& arrays) { return arrays.color; },
          [](ViewArrays& arrays, const py::object& value) { setImage(arrays, &ViewArrays::color, value); },
          "(height, width, 3) uint8: red, green, blue. Of the size of the depth image, or of the colour camera if the "
          "Camera has one.")
      .def_property(
          "confidence", [](const ViewArrays& arrays) { return arrays.confidence; },
          [](ViewArrays& arrays, const py::object& value) { setImage(arrays, &ViewArrays::confidence, value); },
          doc("DepthView::confidence"))
      .def_property_readonly(
          "missing", [](const ViewArrays& arrays) { return arrays.depth.is_none(); }, doc("DepthView::missing"));

  py::class_<FrameLists>(
      module, "RigFrame",
      "The views of one instant: views[i] is what cameras[i] measured, or None if it is missing. Keep the "
      "cameras from frame to frame: everything that depends only on the calibration is then computed once.",
      collected<FrameLists>())
      .def(py::init([](const py::object& cameras, const py::object& views, std::uint64_t stamp) {
             FrameLists lists{listOf(cameras, "cameras"), listOf(views, "views"), stamp};
             checkElements(lists);
             return lists;
           }),
           py::arg("cameras"), py::arg("views"), py::arg("stamp") = 0)
      .def_property(
          "cameras", [](const FrameLists& lists) { return lists.cameras; },
          [](FrameLists& lists, const py::object& value) { lists.cameras = listOf(value, "cameras"); },
          "List of Camera: the calibration of the rig.")
      .def_property(
          "views", [](const FrameLists& lists) { return lists.views; },
          [](FrameLists& lists, const py::object& value) { lists.views = listOf(value, "views"); },
          "List of DepthView, or None: as many as cameras, in their order.")
      .def_readwrite("stamp", &FrameLists::stamp, "Time stamp, which goes into the cloud; microseconds.")
      .def(
          "check", [](const FrameLists& lists) { checkRigFrame(FrameInput(lists).frame); },
          "Raises ValueError, naming the camera and what is wrong, unless every view fits its camera.")
      .def("__repr__", &describeFrame);
}

}  // namespace fuse_flow::python
