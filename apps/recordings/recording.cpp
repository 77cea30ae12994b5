#include <fuse_flow/recordings/recording.h>

#include "recordings/calibrations/posed_recording.h"
#include "recordings/range.h"
#include "recordings/readers/readers.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>

namespace fs = std::filesystem;

namespace fuse_flow::io {
namespace {

constexpr const char* recognised =
    "recognised are a rig recording (rig.json), 7-Scenes (frame-000000.pose.txt), TUM RGB-D (depth.txt, "
    "groundtruth.txt), "
    "Redwood/Open3D (depth/, a .log or camera_trajectory.json), MVSNet (cams/, images/, depth_est/), COLMAP (sparse/, "
    "images/, stereo/) and "
    "organised .pcd files, .mkv files of Azure Kinect and Femto, bags of ROS and RealSense (.bag, .mcap, .db3), and "
    "videos of colour cameras (.mp4, .mov, .avi, …)";

std::unique_ptr<Recording> openFolder(const std::string& folder, const RecordingOptions& options) {
  if (isRigFolder(folder)) return openRig((fs::path(folder) / "rig.json").string(), options);
  if (isSevenScenesFolder(folder)) return openSevenScenes(folder, options);
  if (isTumFolder(folder)) return openTum(folder, options);
  if (isMvsnetFolder(folder)) return openMvsnet(folder, options);  // a .log of its training does not make it Redwood's
  if (isRedwoodFolder(folder)) return openRedwood(folder, options);
  if (isColmapFolder(folder)) return openColmap(folder, options);
  throw InputError(folder + (fs::is_empty(folder) ? ": is an empty folder; " : ": is not a recording; ") + recognised);
}

std::unique_ptr<Recording> openUnposed(const std::vector<std::string>& inputs, const RecordingOptions& options) {
  if (inputs.empty()) throw InputError(std::string("no input was given; ") + recognised);
  if (options.depth_scale && !(*options.depth_scale > 0 && std::isfinite(*options.depth_scale)))
    throw OptionError("--depth-scale is " + std::to_string(*options.depth_scale) +
                      ", must be positive: metres per depth unit");
  const bool of_recorders = std::all_of(
      inputs.begin(), inputs.end(), [](const std::string& input) { return isMkvFile(input) || isVideoFile(input); });
  if (!options.time_offsets.empty() && !of_recorders)
    throw OptionError("--time-offsets: " + inputs[0] + ": is for .mkv files and videos, each with a clock of its own");
  if (!options.time_offsets.empty() && options.time_offsets.size() != inputs.size())
    throw OptionError("--time-offsets: has " + std::to_string(options.time_offsets.size()) + " numbers, must be " +
                      std::to_string(inputs.size()) + ", one for each input");
  for (const double seconds : options.time_offsets)
    if (!(seconds >= 0 && seconds <= 1e6))
      throw OptionError(
          "--time-offsets: has " + std::to_string(seconds) +
          ", must be seconds from 0 to 1000000: by how much later each began than the first moment of all");
  std::error_code error;
  for (const std::string& input : inputs)
    if (!fs::exists(input, error)) throw InputError(input + ": not found; " + recognised);
  if (std::all_of(inputs.begin(), inputs.end(), isPcdFile)) return openPcd(inputs, options);
  if (std::all_of(inputs.begin(), inputs.end(), isVideoFile)) return openVideos(inputs, options);
  if (std::all_of(inputs.begin(), inputs.end(), isMkvFile)) return openMkv(inputs, options);
  if (std::all_of(inputs.begin(), inputs.end(), isMessageLog)) return openMessageLogs(inputs, options);
  if (inputs.size() > 1)
    throw InputError(
        inputs[1] +
        ": several inputs must all be .pcd files, all .mkv files, all bags, or all videos; of other recordings "
        "only one can be given");
  if (fs::is_directory(inputs[0])) return openFolder(inputs[0], options);
  if (fs::path(inputs[0]).extension() == ".json") return openRig(inputs[0], options);
  if (fs::path(inputs[0]).extension() == ".ply")
    throw InputError(inputs[0] + ": is a cloud, which pcl_viewer shows, and no recording; " + recognised);
  throw InputError(inputs[0] + ": is not a recording; " + recognised);
}

}  // namespace

bool isRecordingFolder(const std::string& folder) {
  return isRigFolder(folder) || isSevenScenesFolder(folder) || isTumFolder(folder) || isMvsnetFolder(folder) ||
         isRedwoodFolder(folder) || isColmapFolder(folder) || isMessageLog(folder);
}

std::vector<std::size_t> Recording::frames() const {
  std::vector<std::size_t> numbers(frameCount());
  std::iota(numbers.begin(), numbers.end(), std::size_t{0});
  return numbers;
}

std::vector<std::size_t> chooseFrames(const Recording& recording, const std::string& spec, const std::string& option) {
  return spec.empty() ? recording.frames() : parseRangeOf(spec, recording.frames(), option);
}

std::unique_ptr<Recording> openRecording(const std::vector<std::string>& inputs, const RecordingOptions& options) {
  std::unique_ptr<Recording> recording = withConvention(openUnposed(inputs, options), options.pose_convention);
  return options.poses.empty() ? std::move(recording) : withPoses(std::move(recording), options.poses);
}

}  // namespace fuse_flow::io
