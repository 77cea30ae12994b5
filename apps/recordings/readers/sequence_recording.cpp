#include "recordings/readers/sequence_recording.h"

#include "recordings/calibrations/calibration.h"
#include "recordings/calibrations/intrinsics_file.h"
#include "recordings/image_folders/unused_images.h"
#include "recordings/images/image_io.h"
#include "recordings/range.h"

#include <algorithm>
#include <filesystem>

namespace fuse_flow::io {
namespace {

class SequenceRecording : public Recording {
 public:
  SequenceRecording(Sequence sequence, const Intrinsics& intrinsics, std::vector<std::size_t> views,
                    const RecordingOptions& options)
      : sequence_(std::move(sequence)),
        intrinsics_(intrinsics),
        views_(std::move(views)),
        slide_(static_cast<std::size_t>(options.slide)),
        loading_(options) {
    while (slide_ > 0 && allExist(frame_count_)) ++frame_count_;
    for (std::size_t view = 0; view < views_.size(); ++view) cameras_.push_back(cameraOf(frameOf(view, 0)));
    frames_per_second_ = medianRate();
    warnings_ = sequence_.warnings;
    warnOfUnposed();
  }

  std::string kind() const override { return sequence_.kind; }
  std::size_t frameCount() const override { return frame_count_; }
  std::optional<double> framesPerSecond() const override { return frames_per_second_; }
  const std::vector<Camera>& cameras() const override { return cameras_; }
  std::vector<std::string> inputs() const override { return sequence_.inputs; }

  void read(std::size_t frame, LoadedFrame& out) override {
    out.images.resize(views_.size());
    out.rig.cameras.resize(views_.size());
    out.rig.views.resize(views_.size());
    out.rig.stamp = frameOf(0, frame).stamp;
    out.damaged.clear();
    for (std::size_t view = 0; view < views_.size(); ++view) {
      const SequenceFrame& source = frameOf(view, frame);
      out.rig.cameras[view] = cameraOf(source);
      checkCameraInput(sequence_.path, out.rig.cameras[view]);
    }
    const auto load = [&](std::size_t view) {
      loadView(frameOf(view, frame).files, out.rig.cameras[view], std::nullopt, out.images[view], out.rig.views[view]);
    };
    loading_.load(views_.size(), load, out);
  }

 private:
  /** \brief The median, for cameras drop frames. */
  std::optional<double> medianRate() const {
    std::vector<double> periods;  // microseconds
    for (std::size_t frame = 1; frame < frame_count_; ++frame)
      periods.push_back(static_cast<double>(frameOf(0, frame).stamp) -
                        static_cast<double>(frameOf(0, frame - 1).stamp));
    if (periods.empty()) return std::nullopt;
    const auto median = periods.begin() + static_cast<std::ptrdiff_t>(periods.size() / 2);
    std::nth_element(periods.begin(), median, periods.end());
    if (!(*median > 0)) return std::nullopt;  // the format has no time
    return 1e6 / *median;
  }
  bool allExist(std::size_t frame) const {
    return std::all_of(views_.begin(), views_.end(),
                       [&](std::size_t number) { return sequence_.frames.count(number + frame * slide_) > 0; });
  }
  const SequenceFrame& frameOf(std::size_t view, std::size_t frame) const {
    return sequence_.frames.at(views_[view] + frame * slide_);
  }
  Camera cameraOf(const SequenceFrame& frame) const {
    Camera camera;
    camera.name = frame.name;
    camera.intrinsics = intrinsics_;
    camera.depth_scale = sequence_.depth_scale;
    camera.T_world_camera = frame.T_world_camera;
    return camera;
  }

  void warnOfUnposed() {
    if (sequence_.unposed.empty()) return;
    const auto& [number, why] = *sequence_.unposed.begin();
    warnings_.push_back(std::to_string(sequence_.unposed.size()) + " of " +
                        std::to_string(sequence_.unposed.size() + sequence_.frames.size()) +
                        " depth images have no pose and cannot be used; the first, frame " + std::to_string(number) +
                        ": " + why);
  }

  Sequence sequence_;
  Intrinsics intrinsics_;
  std::vector<std::size_t> views_;
  std::size_t slide_;
  ViewLoading loading_;
  std::size_t frame_count_{1};
  std::optional<double> frames_per_second_;
  std::vector<Camera> cameras_;
};

std::string listFramesOf(const std::map<std::size_t, SequenceFrame>& frames) {
  std::vector<std::size_t> numbers;
  for (const auto& [number, frame] : frames) numbers.push_back(number);
  return listFrames(numbers);
}

/** \brief Up to four frames, evenly spread. */
std::string suggestViews(const std::map<std::size_t, SequenceFrame>& frames) {
  const std::size_t wanted = std::min<std::size_t>(4, frames.size());
  std::string views;
  for (std::size_t i = 0; i < wanted; ++i) {
    const auto frame = std::next(frames.begin(), static_cast<std::ptrdiff_t>(i * frames.size() / wanted));
    views += (i ? "," : "") + std::to_string(frame->first);
  }
  return views;
}

std::vector<std::size_t> chooseViews(const Sequence& sequence, const std::string& spec) {
  if (spec.empty())
    throw OptionError("--views: " + sequence.path +
                      " is a recording of one moving camera, --views must say which frames act as the cameras " +
                      "of one instant, e.g. --views " + suggestViews(sequence.frames) + "; it has " +
                      listFramesOf(sequence.frames));
  std::size_t last = sequence.frames.rbegin()->first;
  if (!sequence.unposed.empty()) last = std::max(last, sequence.unposed.rbegin()->first);
  const std::vector<std::size_t> views = parseRange(spec, last + 1, "--views");
  for (const std::size_t number : views) {
    if (sequence.frames.count(number) > 0) continue;
    const auto unposed = sequence.unposed.find(number);
    if (unposed != sequence.unposed.end()) throw InputError(unposed->second);
    throw OptionError("--views " + spec + ": frame " + std::to_string(number) + " is not in " + sequence.path +
                      ", which has " + listFramesOf(sequence.frames));
  }
  return views;
}

/** \brief Of the first depth image that there is. */
std::pair<int, int> imageSize(const Sequence& sequence) {
  for (const auto& [number, frame] : sequence.frames) {
    std::error_code error;
    if (!std::filesystem::exists(frame.files.depth, error)) continue;
    DepthImage image;
    readDepthPng(frame.files.depth, image);
    return {image.width, image.height};
  }
  throw InputError(sequence.path + ": has no depth image");
}

Intrinsics intrinsicsOf(Sequence& sequence, const std::string& file) {
  const auto [width, height] = imageSize(sequence);
  const std::string size = std::to_string(width) + "x" + std::to_string(height);
  Intrinsics K;
  if (!file.empty()) {
    K = readIntrinsicsFile(file, width, height, &sequence.warnings);
    sequence.inputs.push_back(file);
    if (K.width > 0 && K.height > 0 && (K.width != width || K.height != height))
      throw InputError(file + ": is of a camera of " + std::to_string(K.width) + "x" + std::to_string(K.height) +
                       " pixels, the depth images of " + sequence.path + " are " + size);
  } else if (const auto found = findIntrinsics(sequence.path, width, height)) {
    K = found->intrinsics;
    sequence.warnings.insert(sequence.warnings.end(), found->warnings.begin(), found->warnings.end());
    sequence.inputs.push_back(found->path);
  } else {
    K = sequence.usual_intrinsics;
    if (K.width != width || K.height != height)
      throw InputError(sequence.path + ": no file says the intrinsics of its camera, whose images are " + size +
                       "; --intrinsics FILE must: a camera_info .yaml, a .json with intrinsic_matrix, a 3x3 matrix as "
                       "text, or COLMAP's cameras.txt");
    if (!sequence.usual_certain)
      sequence.warnings.push_back(sequence.path + ": no file says the intrinsics of its camera; those of " +
                                  sequence.usual_camera + " are taken. --intrinsics FILE gives others");
  }
  K.width = width;
  K.height = height;
  return K;
}

}  // namespace

std::unique_ptr<Recording> openSequence(Sequence sequence, const RecordingOptions& options) {
  if (sequence.frames.empty())
    throw InputError(sequence.unposed.empty() ? sequence.path + ": has no frame with a pose and a depth image"
                                              : sequence.unposed.begin()->second);
  if (options.slide < 0) throw OptionError("--slide is " + std::to_string(options.slide) + ", must be 0 or more");
  if (options.depth_scale) sequence.depth_scale = *options.depth_scale;
  for (const auto& [number, frame] : sequence.frames)
    for (const std::string& file : {frame.files.depth, frame.files.color, frame.files.confidence})
      sequence.inputs.push_back(file);
  const bool any_color = std::any_of(sequence.frames.begin(), sequence.frames.end(),
                                     [](const auto& frame) { return !frame.second.files.color.empty(); });
  if (options.read_color && !any_color && !sequence.color_expected.empty())
    if (std::string line = unusedImages(sequence.path, sequence.color_expected); !line.empty())
      sequence.warnings.push_back(std::move(line));
  if (!options.read_color)
    for (auto& [number, frame] : sequence.frames) frame.files.color.clear();
  std::vector<std::size_t> views = chooseViews(sequence, options.views);
  const Intrinsics intrinsics = intrinsicsOf(sequence, options.intrinsics);
  const std::string path = sequence.path;
  auto recording = std::make_unique<SequenceRecording>(std::move(sequence), intrinsics, std::move(views), options);
  for (const Camera& camera : recording->cameras()) checkCameraInput(path, camera);
  return recording;
}

}  // namespace fuse_flow::io
