#include "../bindings.h"
#include "../frames.h"
#include "../fusion/in_flight.h"
#include "../plain.h"
#include "poses.h"

#include <fuse_flow/calibration/extrinsic_tracking.h>

#include <pybind11/stl.h>

#include <pcl/point_types.h>

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <vector>

namespace fuse_flow::python {
namespace {

namespace py = pybind11;

/** \brief An ExtrinsicTracking, whose thread is done with what it was given before the interpreter ends. */
class Tracking {
 public:
  Tracking(const std::vector<Camera>& cameras, double deviation, const ExtrinsicParameters& parameters,
           const PoseFilterParameters& filter)
      : tracking_(std::make_unique<ExtrinsicTracking<pcl::PointXYZ>>(cameras, deviation, parameters, filter)) {
    all().insert(this);
  }
  ~Tracking() {
    all().erase(this);
    const py::gil_scoped_release release;  // its end waits for the estimate
    tracking_.reset();
  }
  Tracking(const Tracking&) = delete;
  Tracking& operator=(const Tracking&) = delete;

  bool push(const FrameLists& lists) {
    const FrameInput input(lists);
    const InFlight in_flight;
    return tracking_->push(input.frame);
  }
  void finish() {
    const InFlight in_flight;
    tracking_->finish();
  }
  std::shared_ptr<const TrackedPoses> poses() const { return tracking_->poses(); }
  void apply(const FrameLists& lists) const {
    const std::shared_ptr<const TrackedPoses> poses = tracking_->poses();
    if (py::len(lists.cameras) != poses->T_world_camera.size())
      throw py::value_error("fuse_flow.ExtrinsicTracking: the frame has " + std::to_string(py::len(lists.cameras)) +
                            " cameras, the rig " + std::to_string(poses->T_world_camera.size()));
    std::size_t i = 0;
    for (const py::handle camera : lists.cameras) py::cast<Camera&>(camera).T_world_camera = poses->T_world_camera[i++];
  }
  ExtrinsicTracking<pcl::PointXYZ>& tracking() { return *tracking_; }

  static void finishAll() {
    for (Tracking* tracking : all()) tracking->finish();
  }

 private:
  /** \brief Those that are. With the interpreter's lock; never freed, as objects may outlive the module's globals. */
  static std::set<Tracking*>& all() {
    static auto& all = *new std::set<Tracking*>;
    return all;
  }

  std::unique_ptr<ExtrinsicTracking<pcl::PointXYZ>> tracking_;
};

void bindFilter(py::module_& module) {
  auto parameters = named<PoseFilterParameters>(module, "PoseFilterParameters");
  plain(parameters)
      .FUSE_FLOW_FIELD(PoseFilterParameters, drift)
      .FUSE_FLOW_FIELD(PoseFilterParameters, deviation_scale)
      .FUSE_FLOW_FIELD(PoseFilterParameters, min_deviation)
      .FUSE_FLOW_FIELD(PoseFilterParameters, gate)
      .FUSE_FLOW_FIELD(PoseFilterParameters, confirmations);
  named<CameraMotion>(module, "CameraMotion")
      .FUSE_FLOW_RESULT(CameraMotion, camera)
      .def_property_readonly(
          "T_new_old", [](const CameraMotion& m) { return matrixOf(m.T_new_old); }, doc("CameraMotion::T_new_old"))
      .FUSE_FLOW_RESULT(CameraMotion, translation)
      .FUSE_FLOW_RESULT(CameraMotion, rotation);
  py::class_<TrackedPoses, std::shared_ptr<TrackedPoses>>(module, "TrackedPoses", doc("TrackedPoses"))
      .def_property_readonly(
          "T_world_camera", [](const TrackedPoses& p) { return matricesOf(p.T_world_camera); },
          "(N, 4, 4) float64, camera by camera: camera to world, metres.")
      .FUSE_FLOW_RESULT(TrackedPoses, stamp)
      .FUSE_FLOW_RESULT(TrackedPoses, updates)
      .FUSE_FLOW_RESULT(TrackedPoses, moved)
      .FUSE_FLOW_RESULT(TrackedPoses, milliseconds);
}

}  // namespace

void bindTracking(py::module_& module) {
  bindFilter(module);
  using Library = ExtrinsicTracking<pcl::PointXYZ>;
  py::class_<Tracking>(module, "ExtrinsicTracking", doc("ExtrinsicTracking"))
      .def(py::init([](const std::vector<Camera>& cameras, double deviation,
                       const std::optional<ExtrinsicParameters>& parameters,
                       const std::optional<PoseFilterParameters>& filter, unsigned int threads) {
             auto made =
                 std::make_unique<Tracking>(cameras, deviation, parameters.value_or(Library::defaultParameters()),
                                            filter.value_or(PoseFilterParameters()));
             made->tracking().setNumberOfThreads(threads);
             return made;
           }),
           py::arg("cameras"), py::arg("deviation") = 0.02, py::kw_only(), py::arg("parameters") = py::none(),
           py::arg("filter") = py::none(), py::arg("threads") = 1,
           "Starts the thread. cameras: with the initial poses. deviation: standard deviation of these poses, metres "
           "at the scene's "
           "radius. parameters: default default_parameters(). threads: for an estimate; 1 leaves the other cores to "
           "the fusion.")
      .def_static("default_parameters", &Library::defaultParameters, doc("ExtrinsicTracking::defaultParameters"))
      .def("push", &Tracking::push, py::arg("frame"), doc("ExtrinsicTracking::push"))
      .def("finish", &Tracking::finish, doc("ExtrinsicTracking::finish"))
      .def_property_readonly(
          "poses", [](const Tracking& t) { return std::const_pointer_cast<TrackedPoses>(t.poses()); },
          doc("ExtrinsicTracking::poses"))
      .def("apply", &Tracking::apply, py::arg("frame"), doc("ExtrinsicTracking::apply"))
      .def_property(
          "min_interval", [](Tracking& t) { return t.tracking().getMinInterval(); },
          [](Tracking& t, std::uint64_t microseconds) { t.tracking().setMinInterval(microseconds); },
          doc("ExtrinsicTracking::setMinInterval"));
  beforeExit(&Tracking::finishAll);
}

}  // namespace fuse_flow::python
