#include "../bindings.h"
#include "../docstrings.h"
#include "../frames.h"
#include "../fusion/in_flight.h"
#include "../fusion/pool.h"
#include "../images.h"
#include "../warn.h"
#include "paths.h"

#include <fuse_flow/recordings/recording.h>
#include <fuse_flow/recordings/rig_json.h>

#include <pybind11/stl.h>

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace fuse_flow::python {
namespace {

namespace py = pybind11;

template <typename Pixel>
py::object arrayOrNone(const ImageView<Pixel>& image, const py::object& owner) {
  if (!image) return py::none();
  return arrayOf(image, owner);
}

/** \brief The frame's images stay where they were read to. */
FrameLists listsOf(const std::shared_ptr<io::LoadedFrame>& loaded) {
  const py::capsule owner(new std::shared_ptr<io::LoadedFrame>(loaded),
                          [](void* kept) { delete static_cast<std::shared_ptr<io::LoadedFrame>*>(kept); });
  py::list cameras, views;
  for (const Camera& camera : loaded->rig.cameras) cameras.append(py::cast(camera));
  for (const DepthView& view : loaded->rig.views) {
    py::object depth = view.depth16 ? arrayOrNone(view.depth16, owner) : arrayOrNone(view.depth32, owner);
    views.append(ViewArrays{depth, arrayOrNone(view.color, owner), arrayOrNone(view.confidence, owner)});
  }
  return {cameras, views, loaded->rig.stamp};
}

/** \brief Recording of Python. */
class Frames {
 public:
  explicit Frames(std::unique_ptr<io::Recording> recording)
      : recording_(std::move(recording)), numbers_(recording_->frames()) {}

  io::Recording& recording() { return *recording_; }
  const std::vector<std::size_t>& numbers() const { return numbers_; }

  FrameLists read(std::size_t number) {
    if (number >= recording_->frameCount())
      throw py::index_error("frame " + std::to_string(number) + " does not exist: the recording has " +
                            std::to_string(recording_->frameCount()));
    const std::shared_ptr<io::LoadedFrame> loaded = pool_->take();
    const Busy::Inside inside(busy_, "fuse_flow.Recording");
    {
      const InFlight in_flight;
      recording_->read(number, *loaded);
    }
    for (const io::DamagedView& damaged : loaded->damaged) warn(damaged.message);
    for (const io::DamagedView& ended : loaded->ended)
      if (ended_.insert(ended.view).second) warn(ended.message);
    return listsOf(loaded);
  }

 private:
  std::unique_ptr<io::Recording> recording_;
  std::vector<std::size_t> numbers_;
  std::set<std::size_t> ended_;  ///< cameras of which this was said
  Busy busy_;
  std::shared_ptr<Pool<io::LoadedFrame>> pool_ = std::make_shared<Pool<io::LoadedFrame>>();
};

class FrameIterator {
 public:
  explicit FrameIterator(std::shared_ptr<Frames> frames) : frames_(std::move(frames)) {}
  FrameLists next() {
    if (at_ == frames_->numbers().size()) throw py::stop_iteration();
    return frames_->read(frames_->numbers()[at_++]);
  }

 private:
  std::shared_ptr<Frames> frames_;
  std::size_t at_{0};
};

std::shared_ptr<Frames> open(const py::object& paths, const io::RecordingOptions& options) {
  const std::vector<std::string> inputs = pathsOf(paths);
  std::unique_ptr<io::Recording> recording;
  {
    const InFlight in_flight;
    recording = io::openRecording(inputs, options);
  }
  for (const std::string& warning : recording->warnings()) warn(warning);
  return std::make_shared<Frames>(std::move(recording));
}

/** \brief The cameras of a rig.json. What of it no Camera has is said: open() takes it into account. */
std::vector<Camera> readRig(const py::object& path) {
  const io::RigDescription rig = io::readRigJson(pathOf(path));
  for (const std::string& warning : rig.warnings) warn(warning);
  std::vector<Camera> cameras;
  for (const io::RigCamera& camera : rig.cameras) {
    cameras.push_back(camera.camera);
    if (!camera.depth.isZ() || camera.confidence_scale)
      warn("camera '" + camera.camera.name +
           "': what its depth or confidence images mean is no part of a Camera; fuse_flow.open() reads them right");
  }
  return cameras;
}

void writeRig(const py::object& path, const std::vector<Camera>& cameras,
              const std::optional<double>& frames_per_second) {
  io::RigDescription rig;
  rig.frames_per_second = frames_per_second;
  for (const Camera& camera : cameras) {
    checkCamera(camera);
    rig.cameras.emplace_back().camera = camera;
  }
  io::writeRigJson(pathOf(path), rig);
}

std::string optionDocs() {
  std::string text =
      "Opens a recording: a folder, or its rig.json, or files of recorders, or several organised PCD files. Iterating "
      "gives its frames; "
      "what was assumed is said by warnings.\n\nRaises ValueError, naming the path, what is wrong, and what would be "
      "right.\n";
  for (const char* option : {"views", "slide", "depth_scale", "intrinsics", "pose_convention", "poses", "without_poses",
                             "read_color", "skip_damaged", "threads"})
    text += std::string("\n") + option + ": " + doc((std::string("RecordingOptions::") + option).c_str());
  return text;
}

}  // namespace

void bindRecordings(py::module_& module) {
  using io::PoseConvention;
  py::enum_<PoseConvention>(module, "PoseConvention", doc("PoseConvention"))
      .value("CAMERA_TO_WORLD", PoseConvention::CameraToWorld, doc("PoseConvention::CameraToWorld"))
      .value("WORLD_TO_CAMERA", PoseConvention::WorldToCamera, doc("PoseConvention::WorldToCamera"))
      .value("OPENGL", PoseConvention::OpenGl, doc("PoseConvention::OpenGl"));

  py::class_<FrameIterator>(module, "FrameIterator", "The frames of a Recording, one after the other.")
      .def("__iter__", [](const py::object& self) { return self; })
      .def("__next__", &FrameIterator::next);

  py::class_<Frames, std::shared_ptr<Frames>>(module, "Recording",
                                              "A source of frames: a folder of images with a calibration, or files of "
                                              "recorders. The arrays of a frame have the memory that its "
                                              "images were read to; they stay when the next frame is read.")
      .def("__len__", [](const Frames& frames) { return frames.numbers().size(); })
      .def("__iter__", [](const std::shared_ptr<Frames>& frames) { return FrameIterator(frames); })
      .def("read", &Frames::read, py::arg("number"),
           "Reads the frame of a number, one of frames.\n\nRaises ValueError for a damaged file, unless skip_damaged.")
      .def_property_readonly("frames", &Frames::numbers, doc("Recording::frames"))
      .def_property_readonly(
          "kind", [](Frames& frames) { return frames.recording().kind(); }, doc("Recording::kind"))
      .def_property_readonly(
          "frame_count", [](Frames& frames) { return frames.recording().frameCount(); }, doc("Recording::frameCount"))
      .def_property_readonly(
          "frames_per_second", [](Frames& frames) { return frames.recording().framesPerSecond(); },
          doc("Recording::framesPerSecond"))
      .def_property_readonly(
          "cameras", [](Frames& frames) { return frames.recording().cameras(); }, doc("Recording::cameras"))
      .def_property_readonly(
          "warnings", [](Frames& frames) { return frames.recording().warnings(); }, doc("Recording::warnings"));

  module.def("read_rig", &readRig, py::arg("path"),
             "Reads the cameras of a rig.json.\n\nRaises ValueError, naming the file, the camera, the key and what is "
             "expected.");
  module.def("write_rig", &writeRig, py::arg("path"), py::arg("cameras"), py::arg("frames_per_second") = py::none(),
             "Writes a rig.json, the calibration that all tools read. Reading it gives the same numbers.\n\n"
             "frames_per_second: rate at which all cameras take their frames, Hz; default not given.");

  const io::RecordingOptions defaults;
  module.def(
      "open",
      [](const py::object& path, const std::string& views, int slide, const std::optional<float>& depth_scale,
         const std::string& intrinsics, PoseConvention pose_convention, const std::string& poses,
         const std::vector<double>& time_offsets, bool without_poses, bool read_color, bool skip_damaged, int threads) {
        return open(path, {views, slide, depth_scale, intrinsics, pose_convention, poses, time_offsets, without_poses,
                           read_color, skip_damaged, threads});
      },
      py::arg("path"), py::kw_only(), py::arg("views") = defaults.views, py::arg("slide") = defaults.slide,
      py::arg("depth_scale") = py::none(), py::arg("intrinsics") = defaults.intrinsics,
      py::arg("pose_convention") = defaults.pose_convention, py::arg("poses") = defaults.poses,
      py::arg("time_offsets") = defaults.time_offsets, py::arg("without_poses") = defaults.without_poses,
      py::arg("read_color") = defaults.read_color, py::arg("skip_damaged") = defaults.skip_damaged,
      py::arg("threads") = defaults.threads, optionDocs().c_str());
}

}  // namespace fuse_flow::python
