#include "../bindings.h"
#include "../calibration/poses.h"
#include "../frames.h"
#include "../images.h"
#include "../plain.h"
#include "../warn.h"
#include "live/devices.h"
#include "live/live_rig.h"
#include "live/played_cameras.h"
#include "open_ends.h"
#include "paths.h"

#include <fuse_flow/recordings/rig_json.h>

#include <pybind11/chrono.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace fuse_flow::python {
namespace {

namespace py = pybind11;

using Milliseconds = std::chrono::milliseconds;
using Held = std::shared_ptr<const io::LoadedView>;

template <typename Pixel>
py::object readOnlyImage(const ImageView<Pixel>& image, const py::object& owner) {
  if (!image) return py::none();
  return readOnly(arrayOf(image, owner));  // another frame may have it, too
}

/** \brief The images stay where the camera has put them. */
FrameLists frameOf(const io::LiveInstant& instant) {
  py::list cameras, views;
  for (const Camera& camera : instant.rig.cameras) cameras.append(py::cast(camera));
  for (std::size_t i = 0; i < instant.held.size(); ++i) {
    if (!instant.held[i]) {
      views.append(py::none());
      continue;
    }
    const py::capsule owner(new Held(instant.held[i]), [](void* kept) { delete static_cast<Held*>(kept); });
    const DepthView& view = instant.rig.views[i];
    const py::object depth = view.depth16 ? readOnlyImage(view.depth16, owner) : readOnlyImage(view.depth32, owner);
    views.append(ViewArrays{depth, readOnlyImage(view.color, owner), readOnlyImage(view.confidence, owner)});
  }
  return {cameras, views, instant.rig.stamp};
}

/** \brief LiveRig of Python: cameras that run from when it is made until it is closed. */
class RunningRig : public OpenUntilClosed<io::LiveRig> {
 public:
  RunningRig(std::unique_ptr<io::LiveRig> rig, std::chrono::microseconds max_wait)
      : OpenUntilClosed(std::move(rig), "fuse_flow.LiveRig"),
        last_wait_(std::chrono::duration_cast<Milliseconds>(max_wait) + 2 * kSlice) {}

  std::optional<FrameLists> next(double seconds) {
    if (!(seconds >= 0))
      throw py::value_error("fuse_flow.LiveRig: timeout is " + std::to_string(seconds) + " s, must be 0 or more");
    const Busy::Inside inside(busy_, name());
    io::LiveInstant instant;
    auto left = Milliseconds(static_cast<std::int64_t>(1e3 * std::min(seconds, 3e7)));
    for (;; left -= kSlice) {
      {
        io::LiveRig& rig = get();
        const InFlight in_flight;
        // The last images may still wait for others.
        if (!rig.running()) left = std::min(left, last_wait_);
        if (rig.next(std::min(left, kSlice), instant)) break;
      }
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (left <= kSlice) return std::nullopt;
    }
    return frameOf(instant);
  }

  /** \brief Who is silent, the library finds out as it is asked for notices. */
  std::vector<io::CameraStatus> status() {
    hear();
    return get().status();
  }
  std::vector<std::string> takeNotices() {
    hear();
    return std::exchange(notices_, {});
  }

  /** \brief For iterating: waits as long as a camera runs. */
  FrameLists nextOfAll() {
    for (;;) {
      const bool runs = get().running();
      if (std::optional<FrameLists> frame = next(1)) return *frame;
      if (!runs) throw py::stop_iteration();
    }
  }

 private:
  void hear() {
    for (std::string& line : get().takeNotices()) notices_.push_back(std::move(line));
  }

  static constexpr Milliseconds kSlice{50};  // between looks for Ctrl-C, and for the interpreter's end
  const Milliseconds last_wait_;
  std::vector<std::string> notices_;  ///< that nobody has taken yet
};

using Stall = std::tuple<std::size_t, double, double>;

void checkPlay(const io::PlayOptions& play) {
  const auto check = [](bool right, const char* name, double value, const char* must) {
    if (!right)
      throw py::value_error("fuse_flow.LiveRig: " + std::string(name) + " is " + std::to_string(value) + ", must be " +
                            must);
  };
  check(play.speed >= 0.001 && play.speed <= 1000, "speed", play.speed, "0.001 to 1000");
  check(play.jitter >= 0 && play.jitter <= 10, "jitter", play.jitter, "0 to 10 s");
  check(play.drop >= 0 && play.drop <= 1, "drop", play.drop, "0 to 1");
  for (const io::PlayOptions::Stall& stall : play.stalls) {
    check(stall.from >= 0 && stall.from <= 86400, "a stall's beginning", stall.from, "0 to 86400 s");
    check(stall.duration > 0 && stall.duration <= 86400, "a stall's duration", stall.duration, "above 0, to 86400 s");
  }
}

std::vector<std::unique_ptr<io::CameraSource>> sourcesOf(const std::vector<std::string>& names,
                                                         const std::string& poses, const io::PlayOptions& play) {
  std::vector<std::unique_ptr<io::CameraSource>> sources;
  const auto is_device = [](const std::string& name) { return io::isDevice(name); };
  if (std::any_of(names.begin(), names.end(), is_device)) {
    for (const std::string& name : names)
      if (!is_device(name))
        throw io::InputError(name + ": is no device, as the others are; must be devices alone, or a recording alone");
    for (const std::string& name : names) sources.push_back(io::openDevice(name));
    return sources;
  }
  io::RecordingOptions options;
  options.poses = poses;
  options.skip_damaged = true;  // cameras that run do not end for one image
  std::unique_ptr<io::Recording> recording = io::openRecording(names, options);
  std::vector<std::size_t> frames = recording->frames();
  if (frames.empty()) throw io::InputError(names[0] + ": has no frames");
  sources.push_back(std::make_unique<io::PlayedCameras>(std::move(recording), std::move(frames), play));
  return sources;
}

std::unique_ptr<RunningRig> run(const py::object& source, const std::string& poses,
                                const SynchronizerParameters& parameters, const io::PlayOptions& play) {
  const std::vector<std::string> names = pathsOf(source);
  if (names.empty()) throw py::value_error("fuse_flow.LiveRig: source is empty, must be a recording, or devices");
  checkPlay(play);
  std::unique_ptr<io::LiveRig> rig;
  std::vector<std::string> warnings;
  {
    const InFlight in_flight;
    io::LiveRig::Options options;
    options.synchronizer = parameters;
    rig = std::make_unique<io::LiveRig>(sourcesOf(names, poses, play), options);
    if (io::isDevice(names[0]) && !poses.empty()) {
      const io::RigDescription calibrated = io::readRigJson(poses);
      warnings = calibrated.warnings;
      rig->setPoses(poses, calibrated.cameras);
    }
    for (std::string& line : rig->warnings()) warnings.push_back(std::move(line));
  }
  if (const std::vector<std::string> unknown = rig->withoutIntrinsics(); !unknown.empty())
    throw io::InputError("camera '" + unknown[0] + "' does not know its intrinsics: poses='rig.json' must say them");
  for (const std::string& camera : rig->withoutPoses())
    warnings.push_back("nobody knows where camera '" + camera + "' stands: poses='rig.json' says it");
  for (const std::string& line : warnings) warn(line);
  auto running = std::make_unique<RunningRig>(std::move(rig), parameters.max_wait);
  const InFlight in_flight;
  running->get().start();
  return running;
}

std::string liveDocs() {
  std::string text =
      "Cameras that run from here on: devices, as 'openni2:#1', or a recording that is played as if its cameras ran "
      "now, as fuse_flow_live does.\n\nsource: a recording, as for open(), or the name of a device, or several; "
      "list_devices() names them. poses: a rig.json that says where the cameras stand. parameters: how their images "
      "are put together; clocks is chosen. What follows is of a recording.";
  for (const char* option : {"speed", "loop", "jitter", "drop", "own_clocks", "preload"})
    text += std::string("\n\n") + option + ": " + doc((std::string("PlayOptions::") + option).c_str());
  return text +
         "\n\nstalls: cameras that deliver nothing for a while, each the number of the camera, seconds from the start, "
         "and seconds that it takes.\n\nRaises ValueError if a device or recording cannot be opened.";
}

}  // namespace

void bindLive(py::module_& module) {
  using io::CameraStatus;
  named<CameraStatus>(module, "CameraStatus")
      .def_readonly("name", &CameraStatus::name, "Of the camera.")
      .FUSE_FLOW_RESULT(CameraStatus, rate)
      .FUSE_FLOW_RESULT(CameraStatus, received)
      .FUSE_FLOW_RESULT(CameraStatus, lost)
      .FUSE_FLOW_RESULT(CameraStatus, used)
      .FUSE_FLOW_RESULT(CameraStatus, unused)
      .FUSE_FLOW_RESULT(CameraStatus, clock_offset)
      .FUSE_FLOW_RESULT(CameraStatus, silent)
      .def("__repr__", [](const CameraStatus& status) { return io::describe(status); });

  py::class_<RunningRig> rig(module, "LiveRig",
                             "Cameras that run, as one rig: their images are put together by time into frames. "
                             "Iterating gives the newest frame, again and again, and waits for it; frames that come "
                             "while another is fused are left out. The arrays of a frame are read-only.");
  const io::PlayOptions defaults;
  rig.def(py::init([](const py::object& source, const std::string& poses, const SynchronizerParameters& parameters,
                      double speed, bool loop, double jitter, double drop, const std::vector<Stall>& stalls,
                      bool own_clocks, bool preload) {
            io::PlayOptions play;
            play.speed = speed;
            play.loop = loop;
            play.jitter = jitter;
            play.drop = drop;
            for (const auto& [camera, from, duration] : stalls) play.stalls.push_back({camera, from, duration});
            play.own_clocks = own_clocks;
            play.preload = preload;
            return run(source, poses, parameters, play);
          }),
          py::arg("source"), py::kw_only(), py::arg("poses") = "", py::arg("parameters") = SynchronizerParameters(),
          py::arg("speed") = defaults.speed, py::arg("loop") = defaults.loop, py::arg("jitter") = defaults.jitter,
          py::arg("drop") = defaults.drop, py::arg("stalls") = std::vector<Stall>(),
          py::arg("own_clocks") = defaults.own_clocks, py::arg("preload") = defaults.preload, liveDocs().c_str())
      .def("next", &RunningRig::next, py::arg("timeout"),
           "The newest frame, if it was not taken yet. timeout: seconds to wait for one; ≥ 0.\n\nReturns None if none "
           "came in that time, or none will come any more: see running.")
      .def("__iter__", [](const py::object& self) { return self; })
      .def("__next__", &RunningRig::nextOfAll)
      .def_property_readonly(
          "cameras", [](const RunningRig& r) { return r.get().cameras(); }, "List of Camera: the calibration.")
      .def_property_readonly(
          "running", [](const RunningRig& r) { return r.get().running(); },
          "False: no camera will deliver anything more, as when a recording has been played.")
      .def_property_readonly("status", &RunningRig::status, "A CameraStatus of each camera.")
      .def("take_notices", &RunningRig::takeNotices, doc("LiveRig::takeNotices"));
  bindClosing(rig, "Stops the cameras. The end of a with block does so, too.");

  module.def(
      "list_devices",
      [] {
        const InFlight in_flight;
        return io::listDevices();
      },
      "The connected devices, a line each: the name and the model. Of a kind of which none is connected, or that "
      "this build does not open, a line says so.");
}

}  // namespace fuse_flow::python
