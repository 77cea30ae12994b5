#include "recordings/calibrations/depth_to_z.h"
#include "recordings/files/file_io.h"
#include "recordings/image_folders/rig_images.h"
#include "recordings/image_folders/unused_images.h"
#include "recordings/images/float_image.h"
#include "recordings/images/tiff_image.h"
#include "recordings/range.h"
#include "recordings/readers/readers.h"
#include "recordings/readers/view_files.h"

#include <fuse_flow/recordings/rig_json.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>

namespace fs = std::filesystem;

namespace fuse_flow::io {
namespace {

class RigRecording : public Recording {
 public:
  RigRecording(fs::path folder, const RigDescription& rig, const RecordingOptions& options,
               std::vector<std::string> inputs)
      : folder_(std::move(folder)),
        inputs_(std::move(inputs)),
        frames_per_second_(rig.frames_per_second),
        read_color_(options.read_color),
        loading_(options) {
    for (const RigCamera& entry : rig.cameras) {
      cameras_.push_back(entry.camera);
      if (options.depth_scale) cameras_.back().depth_scale = *options.depth_scale;
      confidence_scales_.push_back(entry.confidence_scale);
      meanings_.push_back(entry.depth);
      to_z_.emplace_back(cameras_.back(), entry.depth);
      const fs::path own_folder = folder_ / entry.camera.name;
      color_folders_.push_back(colorFolder(own_folder.string()));
      has_depth_.push_back(color_folders_.back().empty() || isThere((own_folder / "depth").string()));
    }
    image_ = std::all_of(has_depth_.begin(), has_depth_.end(), [](bool depth) { return depth; }) ? "a depth image"
                                                                                                 : "an image";
    warnings_ = rig.warnings;
    warnOfUnusedImages();
    findImages();
    if (!images_.by_time) {
      warnOfGaps();
      warnOfSingles();
    }
    warnOfScales();
  }

  std::string kind() const override { return "rig"; }
  std::size_t frameCount() const override { return frames_.empty() ? 0 : frames_.back() + 1; }
  std::vector<std::size_t> frames() const override { return frames_; }
  std::optional<double> framesPerSecond() const override {
    if (frames_per_second_) return frames_per_second_;
    std::vector<Nanoseconds> stamps;
    for (const auto& [frame, stamp] : images_.stamps) stamps.push_back(stamp);
    const Nanoseconds period = framePeriod(stamps);
    return period > 0 ? std::optional(1e9 / static_cast<double>(period)) : std::nullopt;
  }
  const std::vector<Camera>& cameras() const override { return cameras_; }
  bool hasDepth(std::size_t camera) const override { return has_depth_[camera]; }
  bool hasColor(std::size_t camera) const override { return read_color_ && !color_folders_[camera].empty(); }
  std::optional<float> confidenceScale(std::size_t camera) const override { return confidence_scales_[camera]; }
  DepthMeaning depthMeaning(std::size_t camera) const override { return meanings_[camera]; }
  std::vector<std::string> inputs() const override { return inputs_; }
  std::size_t imagesWithoutPartner(std::size_t camera) const override {
    return images_.without_partner.empty() ? 0 : images_.without_partner[camera];
  }

  bool readsConcurrently() const override { return true; }
  void read(std::size_t frame, LoadedFrame& out) override {
    out.rig.cameras = cameras_;
    out.rig.views.resize(cameras_.size());
    out.images.resize(cameras_.size());
    out.rig.stamp = 0;
    if (const auto stamp = images_.stamps.find(frame); stamp != images_.stamps.end())
      out.rig.stamp = static_cast<std::uint64_t>(stamp->second / 1000);
    else if (frames_per_second_)
      out.rig.stamp = static_cast<std::uint64_t>(std::llround(1e6 * static_cast<double>(frame) / *frames_per_second_));
    out.damaged.clear();
    out.ended.clear();
    const auto load = [&](std::size_t i) {
      loadView(filesOf(i, frame), cameras_[i], confidence_scales_[i], out.images[i], out.rig.views[i]);
      if (out.rig.views[i].depth32)
        for (float& z : out.images[i].depth32.data) z *= cameras_[i].depth_scale;
      to_z_[i].convert(out.images[i], out.rig.views[i]);
    };
    loading_.load(cameras_.size(), load, out);
    for (std::size_t i = 0; i < cameras_.size(); ++i)
      if (namesOf(i).empty() || frame > namesOf(i).rbegin()->first) out.ended.push_back({i, ending(i)});
  }

 private:
  ViewFiles filesOf(std::size_t camera, std::size_t frame) const {
    const fs::path folder = folder_ / cameras_[camera].name;
    const auto found = namesOf(camera).find(frame);
    const bool there = found != namesOf(camera).end();
    ViewFiles files;
    files.color_alone = !has_depth_[camera];
    if (files.color_alone) {
      if (read_color_ && there) files.color = (fs::path(color_folders_[camera]) / found->second).string();
      return files;
    }
    if (!there && images_.by_time) return files;  // a file of this number is of another frame
    const std::string name = there ? found->second : frameStem(frame) + ".png";
    const std::string stem = fs::path(name).stem().string();
    files.depth = (folder / "depth" / name).string();
    files.depth_was_there = there;
    if (const auto& color = images_.cameras[camera].color) {
      files.color = fileOf(*color, frame);
    } else if (read_color_ && !color_folders_[camera].empty()) {
      files.color = findImage(color_folders_[camera], stem);
      if (files.color.empty()) files.color = findImage(color_folders_[camera], frameStem(frame));
    }
    const auto& confidence = images_.cameras[camera].confidence;
    files.confidence = confidence ? fileOf(*confidence, frame) : findConfidence((folder / "confidence").string(), stem);
    return files;
  }

  /** \brief Where no camera has colour; of one alone something else is said. */
  void warnOfUnusedImages() {
    if (!read_color_ || std::any_of(color_folders_.begin(), color_folders_.end(), [](const std::string& folder) {
          return !folder.empty() && !filesIn(folder).empty();
        }))
      return;
    for (const Camera& camera : cameras_)
      if (std::string line =
              unusedImages((folder_ / camera.name).string(), "in a folder color, rgb or image beside depth");
          !line.empty())
        warnings_.push_back(std::move(line));
  }

  static std::string fileOf(const FilesByFrame& files, std::size_t frame) {
    const auto found = files.find(frame);
    return found == files.end() ? "" : found->second;
  }

  /** \brief Of a camera's depth images, or, if it is one without depth, its colour images, by frame. */
  const FilesByFrame& namesOf(std::size_t camera) const { return images_.cameras[camera].images; }

  void findImages() {
    std::vector<CameraFolders> folders;
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      const fs::path own = folder_ / cameras_[i].name;
      const bool color = !color_folders_[i].empty() && (read_color_ || !has_depth_[i]);
      folders.push_back({cameras_[i].name, own.string(), has_depth_[i] ? (own / "depth").string() : "",
                         color ? color_folders_[i] : "", (own / "confidence").string()});
    }
    images_ = rigImages(folder_.string(), folders, warnings_);
    listFrames();
  }

  /** \brief A frame that is missing between others was dropped; those behind the last one were never taken. */
  std::string ending(std::size_t camera) const {
    const std::string name = "camera '" + cameras_[camera].name + "' ";
    if (namesOf(camera).empty()) return name + (has_depth_[camera] ? "has no depth images" : "has no colour images");
    const auto begin = frames_.begin();
    const auto end = std::upper_bound(begin, frames_.end(), namesOf(camera).rbegin()->first);
    return name + "ends after " + std::to_string(end - begin) + " of " + std::to_string(frames_.size()) + " frames";
  }

  /** \brief All numbers for which a camera has a depth image, or, if it is one without depth, a colour image. */
  void listFrames() {
    std::set<std::size_t> numbers;
    for (const CameraImages& camera : images_.cameras)
      for (const auto& [number, name] : camera.images) numbers.insert(number);
    frames_.assign(numbers.begin(), numbers.end());
  }

  void warnOfGaps() {
    if (frames_.empty()) return;
    if (frames_.front() > 0)
      warnings_.push_back(folder_.string() + ": begins at frame " + frameStem(frames_.front()) +
                          ", the first of which a camera has " + image_);
    const std::size_t missing = frames_.back() - frames_.front() + 1 - frames_.size();
    if (missing == 0) return;
    std::size_t k = 0;
    while (frames_[k + 1] == frames_[k] + 1) ++k;
    warnings_.push_back(folder_.string() + ": " + std::to_string(missing) + " frames between " +
                        frameStem(frames_.front()) + " and " + frameStem(frames_.back()) +
                        " are left out, no camera has " + image_ + " of them, such as " + frameStem(frames_[k] + 1));
  }

  /** \brief Names by a camera's own clock or counter would put each camera into an instant of its own. */
  void warnOfSingles() {
    std::map<std::size_t, std::size_t> counts;
    std::size_t with_images = 0;
    for (const CameraImages& camera : images_.cameras) {
      with_images += camera.images.empty() ? 0 : 1;
      for (const auto& [number, name] : camera.images) ++counts[number];
    }
    const auto shared = [](const auto& entry) { return entry.second > 1; };
    if (with_images < 2 || std::any_of(counts.begin(), counts.end(), shared)) return;
    warnings_.push_back(folder_.string() + ": no two cameras have " + image_ +
                        " of the same number; images of one instant must have the "
                        "same number in every camera's folder");
  }

  /** \brief Whether a camera's first image has its depth in float. One that is damaged is named when it is read. */
  bool depthIsFloat(std::size_t camera) const {
    const std::string& name = namesOf(camera).begin()->second;
    if (!isTiff(name)) return isFloatImage(name);
    try {
      return tiffIsFloat((folder_ / cameras_[camera].name / "depth" / name).string());
    } catch (const InputError&) {
      return false;
    }
  }

  /** \brief Depth in float is mostly in metres. */
  void warnOfScales() {
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      if (namesOf(i).empty() || !has_depth_[i] || !depthIsFloat(i) || cameras_[i].depth_scale == 1.0f) continue;
      std::ostringstream line;
      line << "camera '" << cameras_[i].name << "': its depth in float is multiplied by its depth_scale, "
           << cameras_[i].depth_scale << "; if it is in metres, that must be 1";
      warnings_.push_back(line.str());
    }
  }

  fs::path folder_;
  std::vector<std::string> inputs_;
  std::optional<double> frames_per_second_;
  bool read_color_;
  ViewLoading loading_;
  std::vector<Camera> cameras_;
  std::vector<std::optional<float>> confidence_scales_;
  std::vector<DepthMeaning> meanings_;
  std::vector<DepthToZ> to_z_;
  /** \brief Of each camera. One that has a folder of colour images, and none of depth, is one without depth. */
  std::vector<bool> has_depth_;
  RigImages images_;
  std::vector<std::string> color_folders_;  ///< of each camera; empty: it has none
  std::string image_;                       ///< what makes a frame: "a depth image"
  std::vector<std::size_t> frames_;
};

/** \brief Throws where depth images have no unit. */
void checkScales(const std::string& json_path, const RigDescription& rig, const Recording& recording) {
  for (std::size_t i = 0; i < rig.cameras.size(); ++i)
    if (recording.hasDepth(i) && !rig.cameras[i].has_depth_scale)
      throw InputError(json_path + ": camera '" + rig.cameras[i].camera.name +
                       "': depth_scale is missing, must be a number: metres per unit of its depth images, like 0.001");
}

/** \brief The images of all cameras, and what simulated ones saw. */
std::vector<std::string> inputsOf(const std::string& json_path, const RigDescription& rig) {
  const fs::path folder = fs::path(json_path).parent_path();
  std::vector<std::string> inputs{json_path, (folder / "truth").string()};
  for (const RigCamera& entry : rig.cameras)
    for (const char* images : {"depth", "color", "rgb", "image", "confidence", "timestamps.txt"})
      inputs.push_back((folder / entry.camera.name / images).string());
  return inputs;
}

}  // namespace

bool isRigFolder(const std::string& folder) { return isThere((fs::path(folder) / "rig.json").string()); }

std::unique_ptr<Recording> openRig(const std::string& json_path, const RecordingOptions& options) {
  if (options.slide != 0) throw OptionError("--slide: " + json_path + " is a recording of several cameras, must be 0");
  if (!options.intrinsics.empty())
    throw OptionError("--intrinsics: " + json_path + " has the intrinsics of its cameras, must not be given");
  RigDescription rig = readRigJson(json_path, false);
  std::vector<std::string> inputs = inputsOf(json_path, rig);
  if (!options.views.empty()) {
    std::vector<RigCamera> chosen;
    for (const std::size_t i : parseRange(options.views, rig.cameras.size(), "--views"))
      chosen.push_back(rig.cameras[i]);
    rig.cameras = std::move(chosen);
  }
  for (const RigCamera& entry : rig.cameras) {
    if (entry.pose_error.empty() || !options.poses.empty()) continue;
    if (!options.without_poses) throw InputError(entry.pose_error);
    rig.warnings.push_back(entry.pose_error + "; it begins at the world's origin");
  }
  fs::path folder = fs::path(json_path).parent_path();
  auto recording = std::make_unique<RigRecording>(std::move(folder), rig, options, std::move(inputs));
  if (recording->frameCount() == 0) {
    const fs::path camera = fs::path(json_path).parent_path() / rig.cameras[0].camera.name;
    throw InputError(json_path + ": there are no depth images, expected files like " +
                     (camera / "depth" / "000000.png").string() + ", or, of a camera without a folder depth, " +
                     (camera / "color" / "000000.png").string());
  }
  if (!options.depth_scale) checkScales(json_path, rig, *recording);
  return recording;
}

}  // namespace fuse_flow::io
