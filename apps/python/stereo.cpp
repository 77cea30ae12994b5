#include "bindings.h"
#include "frames.h"
#include "fusion/in_flight.h"
#include "images.h"
#include "plain.h"

#include <fuse_flow/stereo/epipolar_errors.h>
#include <fuse_flow/stereo/multi_view_stereo.h>

#include <pybind11/stl.h>

#include <memory>
#include <utility>
#include <vector>

namespace fuse_flow::python {
namespace {

namespace py = pybind11;

/** \brief StereoFrame of Python, with the arrays of colour that it points to. */
struct StereoResult {
  std::shared_ptr<StereoFrame> found;
  std::vector<py::object> colors;
};

/** \brief StereoView of Python. */
struct StereoDepth {
  std::shared_ptr<StereoFrame> found;
  std::size_t number{0};

  const StereoView& view() const { return found->views[number]; }
  const Intrinsics& size() const { return found->rig.cameras[number].intrinsics; }
};

py::capsule ownerOf(const std::shared_ptr<StereoFrame>& found) {
  return {new std::shared_ptr<StereoFrame>(found),
          [](void* kept) { delete static_cast<std::shared_ptr<StereoFrame>*>(kept); }};
}

py::object imageOf(const StereoDepth& depth, const std::vector<float>& values) {
  if (values.empty()) return py::none();
  return arrayOf(ImageView<float>(values.data(), depth.size().width, depth.size().height), ownerOf(depth.found));
}

py::object normalsOf(const StereoDepth& depth) {
  static_assert(sizeof(Vec3) == 3 * sizeof(float), "normals are shown as an array of floats");
  const std::vector<Vec3>& normals = depth.view().normals;
  if (normals.empty()) return py::none();
  const std::vector<py::ssize_t> shape{depth.size().height, depth.size().width, 3};
  return py::array(py::dtype::of<float>(), shape, {}, normals.data(), ownerOf(depth.found));
}

FrameLists rigOf(const StereoResult& result) {
  py::list cameras, views;
  const RigFrame& rig = result.found->rig;
  for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
    cameras.append(py::cast(rig.cameras[i]));
    const StereoDepth depth{result.found, i};
    if (rig.views[i].missing()) {
      views.append(py::none());
      continue;
    }
    views.append(
        ViewArrays{imageOf(depth, depth.view().depth), result.colors[i], imageOf(depth, depth.view().confidence)});
  }
  return {cameras, views, rig.stamp};
}

/** \brief MultiViewStereo of Python. */
class Stereo {
 public:
  Stereo(std::shared_ptr<StereoParameters> parameters, unsigned int threads)
      : parameters_(parameters ? std::move(parameters) : std::make_shared<StereoParameters>()), threads_(threads) {
    stereo_.setParameters(*parameters_);
  }

  StereoResult estimate(const FrameLists& lists) {
    const Busy::Inside inside(busy_, "fuse_flow.MultiViewStereo");
    const FrameInput input(lists);
    StereoResult result{std::make_shared<StereoFrame>(), {}};
    for (const py::handle view : lists.views)
      result.colors.push_back(view.is_none() ? py::object(py::none()) : py::cast<const ViewArrays&>(view).color);
    stereo_.setParameters(*parameters_);
    stereo_.setNumberOfThreads(threads_);
    const InFlight in_flight;
    stereo_.estimate(input.frame, *result.found);
    return result;
  }

  const std::shared_ptr<StereoParameters>& parameters() const { return parameters_; }
  void setParameters(const std::shared_ptr<StereoParameters>& parameters) {
    if (!parameters) throw py::type_error("fuse_flow.MultiViewStereo: parameters is None, must be StereoParameters");
    parameters_ = parameters;
  }

 private:
  MultiViewStereo<> stereo_;
  std::shared_ptr<StereoParameters> parameters_;
  unsigned int threads_;
  Busy busy_;
};

void bindStereoResult(py::module_& module) {
  named<StereoGeometry>(module, "StereoGeometry")
      .FUSE_FLOW_RESULT(StereoGeometry, sources)
      .FUSE_FLOW_RESULT(StereoGeometry, min_depth)
      .FUSE_FLOW_RESULT(StereoGeometry, max_depth)
      .FUSE_FLOW_RESULT(StereoGeometry, baseline)
      .FUSE_FLOW_RESULT(StereoGeometry, min_angle)
      .FUSE_FLOW_RESULT(StereoGeometry, max_angle)
      .FUSE_FLOW_RESULT(StereoGeometry, parallel_baselines);
  py::class_<StereoDepth>(module, "StereoView", doc("StereoView"))
      .def_property_readonly(
          "depth", [](const StereoDepth& d) { return imageOf(d, d.view().depth); },
          "(height, width) float32, metres; 0: none. None if the view has no colour image.")
      .def_property_readonly(
          "confidence", [](const StereoDepth& d) { return imageOf(d, d.view().confidence); },
          doc("StereoView::confidence"))
      .def_property_readonly(
          "normals", &normalsOf,
          "(height, width, 3) float32, world frame, of length 1, facing the camera; zero where there is no depth.")
      .def_property_readonly(
          "geometry", [](const StereoDepth& d) { return d.view().geometry; }, doc("StereoView::geometry"))
      .def_property_readonly(
          "agreeing", [](const StereoDepth& d) { return d.view().agreeing; }, doc("StereoView::agreeing"));
  py::class_<StereoResult>(module, "StereoFrame", doc("StereoFrame"))
      .def_property_readonly(
          "rig", &rigOf,
          "The input of FuseFlow.fuse(), with FuseFlowParameters.estimated_depth(): its views have depth and "
          "confidence, its cameras are those of the colour images, with the noise of such depth. Its arrays are not "
          "copied.")
      .def_property_readonly(
          "views",
          [](const StereoResult& result) {
            std::vector<StereoDepth> views;
            for (std::size_t i = 0; i < result.found->views.size(); ++i) views.push_back({result.found, i});
            return views;
          },
          doc("StereoFrame::views"))
      .def_property_readonly(
          "total_ms", [](const StereoResult& r) { return r.found->total_ms; }, doc("StereoFrame::total_ms"));
}

std::vector<EpipolarError> errorsOf(const FrameLists& lists, const StereoParameters& parameters, unsigned int threads) {
  const FrameInput input(lists);
  const InFlight in_flight;
  return epipolarErrors(input.frame, parameters, threads);
}

}  // namespace

void bindStereo(py::module_& module) {
  auto parameters = named<StereoParameters, std::shared_ptr<StereoParameters>>(module, "StereoParameters");
  plain(parameters)
      .FUSE_FLOW_FIELD(StereoParameters, max_sources)
      .FUSE_FLOW_FIELD(StereoParameters, best_sources)
      .FUSE_FLOW_FIELD(StereoParameters, min_depth)
      .FUSE_FLOW_FIELD(StereoParameters, max_depth)
      .FUSE_FLOW_FIELD(StereoParameters, levels)
      .FUSE_FLOW_FIELD(StereoParameters, sweep_step)
      .FUSE_FLOW_FIELD(StereoParameters, max_planes)
      .FUSE_FLOW_FIELD(StereoParameters, coarse_passes)
      .FUSE_FLOW_FIELD(StereoParameters, fine_passes)
      .FUSE_FLOW_FIELD(StereoParameters, window_spacing)
      .FUSE_FLOW_FIELD(StereoParameters, level_sigma)
      .FUSE_FLOW_FIELD(StereoParameters, min_variance)
      .FUSE_FLOW_FIELD(StereoParameters, geometric_weight)
      .FUSE_FLOW_FIELD(StereoParameters, geometric_limit)
      .FUSE_FLOW_FIELD(StereoParameters, min_incidence)
      .FUSE_FLOW_FIELD(StereoParameters, edge_step)
      .FUSE_FLOW_FIELD(StereoParameters, repetition_reach)
      .FUSE_FLOW_FIELD(StereoParameters, seed);
  bindStereoResult(module);
  py::class_<Stereo>(module, "MultiViewStereo", doc("MultiViewStereo"))
      .def(py::init<std::shared_ptr<StereoParameters>, unsigned int>(), py::arg("parameters") = py::none(),
           py::kw_only(), py::arg("threads") = 0)
      .def("estimate", &Stereo::estimate, py::arg("frame"), doc("MultiViewStereo::estimate"))
      .def_property("parameters", &Stereo::parameters, &Stereo::setParameters, doc("StereoParameters"));
  named<EpipolarError>(module, "EpipolarError")
      .FUSE_FLOW_RESULT(EpipolarError, view)
      .FUSE_FLOW_RESULT(EpipolarError, source)
      .FUSE_FLOW_RESULT(EpipolarError, matches)
      .FUSE_FLOW_RESULT(EpipolarError, median);
  module.def("epipolar_errors", &errorsOf, py::arg("frame"), py::kw_only(), py::arg("parameters") = StereoParameters(),
             py::arg("threads") = 0, doc("epipolarErrors"));
}

}  // namespace fuse_flow::python
