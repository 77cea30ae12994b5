#include "../bindings.h"
#include "../docstrings.h"
#include "../frames.h"
#include "../fusion/in_flight.h"
#include "../warn.h"
#include "live/device_conversions.h"
#include "paths.h"
#include "recordings/files/file_io.h"
#include "recordings/readers/view_files.h"

#include <fuse_flow/recordings/rig_writer.h>

#include <pybind11/stl.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace fuse_flow::python {
namespace {

namespace py = pybind11;

/** \brief RigWriter of Python: frames of arrays become those of the library, with images of their own. */
class RecordingWriter {
 public:
  RecordingWriter(std::string folder, std::vector<Camera> cameras, const std::optional<double>& frames_per_second,
                  const std::optional<std::vector<bool>>& has_depth)
      : folder_(std::move(folder)), timed_(!frames_per_second), cameras_(std::move(cameras)) {
    io::RigDescription rig;
    rig.frames_per_second = frames_per_second;
    if (frames_per_second && !(*frames_per_second >= 0.001 && *frames_per_second <= 1e6))
      fail("frames_per_second is " + std::to_string(*frames_per_second) + ", must be 0.001 to 1000000");
    if (cameras_.empty()) fail("there is no camera");
    if (has_depth && has_depth->size() != cameras_.size())
      fail("has_depth is of " + std::to_string(has_depth->size()) + " cameras, must be of " +
           std::to_string(cameras_.size()));
    std::set<std::string> names;
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      checkCamera(cameras_[i]);
      const std::string& name = cameras_[i].name;
      if (name.empty() || name == "." || name == ".." || name.find_first_of(std::string("/\\\n\0", 4)) != name.npos)
        fail("camera " + std::to_string(i) + " is named '" + name + "', must be the name of a folder");
      if (!names.insert(name).second) fail("two cameras are named '" + name + "', must have names of their own");
      has_depth_.push_back(!has_depth || (*has_depth)[i]);
      io::RigCamera camera{cameras_[i]};
      camera.has_depth_scale = has_depth_.back();
      rig.cameras.push_back(std::move(camera));
    }
    const InFlight in_flight;
    if (io::isThere(folder_ + "/rig.json"))  // its frames and the new ones would be one recording
      throw io::InputError(folder_ + ": is a recording already, must be a new folder");
    writer_.emplace(folder_, std::move(rig), false);
  }

  void write(const FrameLists& lists, const std::optional<std::size_t>& number) {
    const Busy::Inside inside(busy_, "fuse_flow.RigWriter");
    FrameInput input(lists);
    RigFrame& frame = input.frame;
    check(frame);
    const std::size_t as = number.value_or(next_);
    const InFlight in_flight;
    images_.rig.views = frame.views;
    images_.images.resize(frame.views.size());
    for (std::size_t i = 0; i < frame.views.size(); ++i) copy(frame.views[i], i);
    writer_->write(as, images_);
    stamps_[as] = frame.stamp;
    std::set<std::size_t>& written = written_[as];
    for (std::size_t i = 0; i < frame.views.size(); ++i)
      if (has_depth_[i] ? !frame.views[i].missing() : static_cast<bool>(frame.views[i].color)) written.insert(i);
    next_ = as + 1;
  }

  void finish() {
    const Busy::Inside inside(busy_, "fuse_flow.RigWriter");
    const bool timed = timed_ && timesAreTimes();
    if (timed_ && !timed && stampsDiffer())
      warn(
          "fuse_flow.RigWriter: the recording has no times, as the stamps of its frames do not rise from number to "
          "number; must rise, or give frames_per_second");
    const InFlight in_flight;
    if (timed) writeTimes();
    writer_->finish();
  }

 private:
  [[noreturn]] static void fail(const std::string& what) { throw py::value_error("fuse_flow.RigWriter: " + what); }

  void check(const RigFrame& frame) const {
    if (frame.views.size() != cameras_.size())
      fail("the frame has " + std::to_string(frame.views.size()) + " views, must have " +
           std::to_string(cameras_.size()) + ", one for each camera, or None");
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      detail::checkView(cameras_[i], frame.views[i]);
      const std::string of = "depth of camera '" + cameras_[i].name + "' is ";
      if (!has_depth_[i] && !frame.views[i].missing()) fail(of + "there, but has_depth says it has none");
      if (frame.views[i].depth32 && cameras_[i].depth_scale != 1.0f)
        fail(of + "float32, in metres: its depth_scale is " + std::to_string(cameras_[i].depth_scale) + ", must be 1");
    }
  }

  template <typename Pixel>
  static void copyImage(const ImageView<Pixel>& from, io::Image<Pixel>& to) {
    if (from) io::copyRows(from.data, from.row_stride, from.width, from.height, to);
  }

  void copy(const DepthView& view, std::size_t camera) {
    io::LoadedView& images = images_.images[camera];
    copyImage(view.depth16, images.depth16);
    copyImage(view.depth32, images.depth32);
    copyImage(view.color, images.color);
    copyImage(view.confidence, images.confidence);
    // As colour comes: whether there will be some, nobody has said.
    if (view.color && with_color_.insert(camera).second)
      io::makeFolder((std::filesystem::path(folder_) / cameras_[camera].name / "color").string());
  }

  /** \brief Whether the stamps tell when frames were taken: they rise. */
  bool timesAreTimes() const {
    const std::uint64_t* before = nullptr;
    for (const auto& [number, stamp] : stamps_) {
      if (before != nullptr && stamp <= *before) return false;
      before = &stamp;
    }
    return stamps_.size() > 1;
  }

  bool stampsDiffer() const {
    return std::any_of(stamps_.begin(), stamps_.end(),
                       [this](const auto& frame) { return frame.second != stamps_.begin()->second; });
  }

  /** \brief A timestamps.txt for each camera, of the frames that it has; seconds. */
  void writeTimes() const {
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      std::string lines;
      for (const auto& [number, stamp] : stamps_) {
        if (written_.at(number).count(i) == 0) continue;
        char time[40];
        std::snprintf(time, sizeof time, " %llu.%06llu\n", static_cast<unsigned long long>(stamp / 1000000),
                      static_cast<unsigned long long>(stamp % 1000000));
        lines += io::frameStem(number) + time;
      }
      if (!lines.empty())
        io::writeFile((std::filesystem::path(folder_) / cameras_[i].name / "timestamps.txt").string(), lines);
    }
  }

  std::string folder_;
  bool timed_;  ///< by the stamps of frames
  std::vector<Camera> cameras_;
  std::vector<bool> has_depth_;
  std::optional<io::RigWriter> writer_;
  io::LoadedFrame images_;  ///< as the library takes them; with memory that is reused
  std::set<std::size_t> with_color_;
  std::size_t next_{0};
  std::map<std::size_t, std::uint64_t> stamps_;           ///< of each frame
  std::map<std::size_t, std::set<std::size_t>> written_;  ///< the cameras of each frame
  Busy busy_;
};

}  // namespace

void bindRigWriter(py::module_& module) {
  py::class_<RecordingWriter>(
      module, "RigWriter",
      "Writes a recording that fuse_flow.open and all tools read: a folder with rig.json, and for each camera "
      "images of depth, colour and confidence, as far as frames have them.")
      .def(py::init([](const py::object& path, const std::vector<Camera>& cameras,
                       const std::optional<double>& frames_per_second,
                       const std::optional<std::vector<bool>>& has_depth) {
             return std::make_unique<RecordingWriter>(pathOf(path), cameras, frames_per_second, has_depth);
           }),
           py::arg("path"), py::arg("cameras"), py::arg("frames_per_second") = py::none(), py::kw_only(),
           py::arg("has_depth") = py::none(),
           "path: a new folder. cameras: each with a name of its own, which is that of its folder.\n\n"
           "frames_per_second: rate at which all cameras take their frames, Hz; default: the stamps of the frames say "
           "when they were taken, if they rise.\n\nhas_depth: of each camera, whether it measures depth, or colour "
           "alone; default: all do.")
      .def("write", &RecordingWriter::write, py::arg("frame"), py::arg("number") = py::none(),
           "Writes the images of a frame. Its views are those of the cameras that the writer was made with; of a view "
           "that is None, nothing is written. Depth in float32 needs a camera with depth_scale = 1.\n\nnumber: of the "
           "frame; default: one more than the one before.\n\nRaises ValueError if a view does not fit its camera, "
           "OSError if it cannot be written.")
      .def("finish", &RecordingWriter::finish,
           "Writes rig.json. Without it, the folder is not yet a recording. The end of a with block does so, also when "
           "an exception ends it.")
      .def("__enter__", [](const py::object& self) { return self; })
      .def("__exit__", [](RecordingWriter& self, const py::args&) { self.finish(); });
}

}  // namespace fuse_flow::python
