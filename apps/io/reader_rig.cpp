#include "io/file_io.h"
#include "io/range.h"
#include "io/readers.h"
#include "io/rig_json.h"
#include "io/view_files.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace fs = std::filesystem;

namespace fuse_flow::io {
namespace {

/** \brief One more than the highest number among folder/NNNNNN.png; 0 if there is none. */
std::size_t countFrames(const fs::path& folder) {
  std::size_t count = 0;
  for (const std::string& name : filesIn(folder.string())) {
    const std::string stem = fs::path(name).stem().string();
    const bool numbered =
        stem.size() == 6 && std::all_of(stem.begin(), stem.end(), [](char c) { return c >= '0' && c <= '9'; });
    if (numbered && fs::path(name).extension() == ".png") count = std::max<std::size_t>(count, std::stoul(stem) + 1);
  }
  return count;
}

class RigRecording : public Recording {
 public:
  RigRecording(fs::path folder, const RigDescription& rig, const RecordingOptions& options,
               std::vector<std::string> inputs)
      : folder_(std::move(folder)),
        inputs_(std::move(inputs)),
        frames_per_second_(rig.frames_per_second),
        read_color_(options.read_color),
        skip_damaged_(options.skip_damaged) {
    for (const RigCamera& entry : rig.cameras) {
      cameras_.push_back(entry.camera);
      depth_scales_.push_back(options.depth_scale.value_or(entry.depth_scale));
      counts_.push_back(countFrames(folder_ / entry.camera.name / "depth"));
      frame_count_ = std::max(frame_count_, counts_.back());
    }
  }

  std::string kind() const override { return "rig"; }
  std::size_t frameCount() const override { return frame_count_; }
  std::optional<double> framesPerSecond() const override { return frames_per_second_; }
  const std::vector<Camera>& cameras() const override { return cameras_; }
  std::vector<std::string> inputs() const override { return inputs_; }

  void read(std::size_t frame, LoadedFrame& out) override {
    out.rig.cameras = cameras_;
    out.rig.views.resize(cameras_.size());
    out.images.resize(cameras_.size());
    out.rig.stamp = 0;
    if (frames_per_second_)
      out.rig.stamp = static_cast<std::uint64_t>(std::llround(1e6 * static_cast<double>(frame) / *frames_per_second_));
    out.damaged.clear();
    out.ended.clear();
    const std::string stem = frameStem(frame);
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      const fs::path camera = folder_ / cameras_[i].name;
      ViewFiles files;
      files.depth = (camera / "depth" / (stem + ".png")).string();
      if (read_color_) files.color = findImage((camera / "color").string(), stem);
      files.confidence = (camera / "confidence" / (stem + ".png")).string();
      loadView(files, depth_scales_[i], i, skip_damaged_, out);
      if (frame >= counts_[i]) out.ended.push_back({i, ending(i)});
    }
  }

 private:
  /** \brief A frame that is missing between others was dropped; those behind the last one were never taken. */
  std::string ending(std::size_t camera) const {
    const std::string name = "camera '" + cameras_[camera].name + "' ";
    if (counts_[camera] == 0) return name + "has no depth images";
    return name + "ends after " + std::to_string(counts_[camera]) + " of " + std::to_string(frame_count_) + " frames";
  }

  fs::path folder_;
  std::vector<std::string> inputs_;
  std::optional<double> frames_per_second_;
  bool read_color_;
  bool skip_damaged_;
  std::vector<Camera> cameras_;
  std::vector<float> depth_scales_;
  std::vector<std::size_t> counts_;  ///< of frames, each camera's
  std::size_t frame_count_{0};
};

/** \brief The images of all cameras, and what simulated ones saw. */
std::vector<std::string> inputsOf(const std::string& json_path, const RigDescription& rig) {
  const fs::path folder = fs::path(json_path).parent_path();
  std::vector<std::string> inputs{json_path, (folder / "truth").string()};
  for (const RigCamera& entry : rig.cameras)
    for (const char* images : {"depth", "color", "rgb", "image", "confidence"})
      inputs.push_back((folder / entry.camera.name / images).string());
  return inputs;
}

}  // namespace

bool isRigFolder(const std::string& folder) { return isThere((fs::path(folder) / "rig.json").string()); }

std::unique_ptr<Recording> openRig(const std::string& json_path, const RecordingOptions& options) {
  if (options.slide != 0) throw OptionError("--slide: " + json_path + " is a recording of several cameras, must be 0");
  RigDescription rig = readRigJson(json_path);
  std::vector<std::string> inputs = inputsOf(json_path, rig);
  if (!options.views.empty()) {
    std::vector<RigCamera> chosen;
    for (const std::size_t i : parseRange(options.views, rig.cameras.size(), "--views"))
      chosen.push_back(rig.cameras[i]);
    rig.cameras = std::move(chosen);
  }
  fs::path folder = fs::path(json_path).parent_path();
  auto recording = std::make_unique<RigRecording>(std::move(folder), rig, options, std::move(inputs));
  if (recording->frameCount() == 0)
    throw InputError(
        json_path + ": there are no depth images, expected files like " +
        (fs::path(json_path).parent_path() / rig.cameras[0].camera.name / "depth" / "000000.png").string());
  return recording;
}

}  // namespace fuse_flow::io
