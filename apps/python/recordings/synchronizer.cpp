#include "../bindings.h"
#include "../fusion/in_flight.h"
#include "../plain.h"

#include <fuse_flow/live/view_synchronizer.h>

#include <pybind11/chrono.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace fuse_flow::python {
namespace {

namespace py = pybind11;

using Microseconds = std::chrono::microseconds;

/** \brief Any object of Python, which the synchroniser may drop in any thread, with the interpreter's lock or without. */
using Payload = std::shared_ptr<PyObject>;

Payload payloadOf(py::object object) {
  return {object.release().ptr(), [](PyObject* kept) {
            const py::gil_scoped_acquire acquire;
            Py_DECREF(kept);
          }};
}

using Synchronizer = ViewSynchronizer<Payload>;

constexpr double kYear = 365 * 24 * 3600.0;  // seconds; longer is as good as for ever

std::optional<Synchronizer::Set> wait(Synchronizer& synchronizer, double seconds) {
  if (!(seconds >= 0))
    throw py::value_error("fuse_flow.ViewSynchronizer: timeout is " + std::to_string(seconds) +
                          " s, must be 0 or more");
  const auto timeout =
      std::chrono::duration_cast<Microseconds>(std::chrono::duration<double>(std::min(seconds, kYear)));
  constexpr Microseconds kSlice =
      std::chrono::milliseconds(50);  // between looks for Ctrl-C, and for the interpreter's end
  using Clock = std::chrono::steady_clock;
  const Clock::time_point end = Clock::now() + timeout;
  for (;;) {
    const auto left = std::chrono::duration_cast<Microseconds>(end - Clock::now());
    {
      const InFlight in_flight;
      if (auto set = synchronizer.wait(std::clamp(left, Microseconds(0), kSlice))) return set;
    }
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (left <= kSlice) return std::nullopt;
  }
}

void bindCounts(py::module_& module) {
  using Statistics = SynchronizerStatistics;
  using CameraCounts = SynchronizerStatistics::Camera;
  py::class_<CameraCounts>(module, "SynchronizerCamera", doc("SynchronizerStatistics::Camera"))
      .def_readonly("received", &CameraCounts::received, doc("SynchronizerStatistics::Camera::received"))
      .def_readonly("used", &CameraCounts::used, doc("SynchronizerStatistics::Camera::used"))
      .def_readonly("overrun", &CameraCounts::overrun, doc("SynchronizerStatistics::Camera::overrun"))
      .def_readonly("unmatched", &CameraCounts::unmatched, doc("SynchronizerStatistics::Camera::unmatched"))
      .def_readonly("late", &CameraCounts::late, doc("SynchronizerStatistics::Camera::late"))
      .def_readonly("repeated", &CameraCounts::repeated, doc("SynchronizerStatistics::Camera::repeated"))
      .def_readonly("waiting", &CameraCounts::waiting, doc("SynchronizerStatistics::Camera::waiting"))
      .def_readonly("restarts", &CameraCounts::restarts, doc("SynchronizerStatistics::Camera::restarts"))
      .def_readonly("offset", &CameraCounts::offset, doc("SynchronizerStatistics::Camera::offset"))
      .def_readonly("waited_for", &CameraCounts::waited_for, doc("SynchronizerStatistics::Camera::waited_for"));
  named<SynchronizerStatistics>(module, "SynchronizerStatistics")
      .def_readonly("cameras", &Statistics::cameras, doc("SynchronizerStatistics::cameras"))
      .def_readonly("complete_sets", &Statistics::complete_sets, doc("SynchronizerStatistics::complete_sets"))
      .def_readonly("incomplete_sets", &Statistics::incomplete_sets, doc("SynchronizerStatistics::incomplete_sets"))
      .def_readonly("mean_spread", &Statistics::mean_spread, doc("SynchronizerStatistics::mean_spread"))
      .def_readonly("largest_spread", &Statistics::largest_spread, doc("SynchronizerStatistics::largest_spread"));
}

void bindSet(py::module_& module) {
  using Set = Synchronizer::Set;
  py::class_<Set>(module, "SynchronizedSet", doc("SynchronizedSet"))
      .def_readonly("stamp", &Set::stamp, doc("SynchronizedSet::stamp"))
      .def_readonly("spread", &Set::spread, doc("SynchronizedSet::spread"))
      .def_property_readonly(
          "views",
          [](const Set& set) {
            py::list views;
            for (const auto& view : set.views)
              views.append(view ? py::reinterpret_borrow<py::object>(view->payload.get()) : py::none());
            return views;
          },
          "List: views[i] is what was pushed for camera i; None if the camera is missing.")
      .def_property_readonly(
          "stamps",
          [](const Set& set) {
            std::vector<std::optional<std::uint64_t>> stamps;
            for (const auto& view : set.views) stamps.push_back(view ? std::optional(view->stamp) : std::nullopt);
            return stamps;
          },
          "List: the stamps as they were pushed, microseconds; None if the camera is missing.");
}

}  // namespace

void bindSynchronizer(py::module_& module) {
  py::enum_<ClockModel>(module, "ClockModel", doc("ClockModel"))
      .FUSE_FLOW_VALUE(ClockModel, Shared)
      .FUSE_FLOW_VALUE(ClockModel, Separate);
  auto parameters = named<SynchronizerParameters>(module, "SynchronizerParameters");
  plain(parameters)
      .FUSE_FLOW_FIELD(SynchronizerParameters, tolerance)
      .FUSE_FLOW_FIELD(SynchronizerParameters, max_wait)
      .FUSE_FLOW_FIELD(SynchronizerParameters, capacity)
      .FUSE_FLOW_FIELD(SynchronizerParameters, clocks)
      .FUSE_FLOW_FIELD(SynchronizerParameters, offset_window);
  bindCounts(module);
  bindSet(module);
  py::class_<Synchronizer>(module, "ViewSynchronizer", doc("ViewSynchronizer"))
      .def(py::init([](std::size_t cameras, const SynchronizerParameters& values) {
             return std::make_unique<Synchronizer>(cameras, values);
           }),
           py::arg("cameras"), py::arg("parameters") = SynchronizerParameters())
      .def(
          "push",
          [](Synchronizer& synchronizer, std::size_t camera, std::uint64_t stamp, py::object view) {
            Payload payload = payloadOf(std::move(view));
            const InFlight in_flight;  // another thread may hold the synchroniser's lock, and want the interpreter's
            synchronizer.push(camera, stamp, std::move(payload));
          },
          py::arg("camera"), py::arg("stamp"), py::arg("view"),
          "Hands over a view, any object, such as a DepthView. May be called from any thread, and never waits for a "
          "consumer.\n\n"
          "camera: its number, from 0. stamp: time of exposure, microseconds of the camera's clock.")
      .def(
          "take",
          [](Synchronizer& synchronizer) {
            const InFlight in_flight;
            return synchronizer.take();
          },
          doc("ViewSynchronizer::take"))
      .def("wait", &wait, py::arg("timeout"),
           "As take(), but waits for a set. timeout: longest time to wait, seconds; ≥ 0.\n\n"
           "Returns None if there was none in that time.")
      .def_property_readonly("statistics", &Synchronizer::getStatistics, doc("ViewSynchronizer::getStatistics"));
}

}  // namespace fuse_flow::python
