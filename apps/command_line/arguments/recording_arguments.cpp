#include "command_line/arguments/recording_arguments.h"

#include "command_line/arguments/option_checks.h"

#include <algorithm>
#include <iostream>
#include <limits>
#include <map>

namespace fuse_flow::command_line {

void addCalibrationOptions(CLI::App& app, io::RecordingOptions& options) {
  app.add_option("--intrinsics", options.intrinsics,
                 "of the camera of a 7-Scenes, TUM or Redwood folder: a ROS camera_info .yaml, an Open3D .json, a 3x3 "
                 "matrix as text, or COLMAP's cameras.txt; default: such a file in the folder")
      ->check(path());
  static const std::map<std::string, io::PoseConvention> conventions = {
      {"camera_to_world", io::PoseConvention::CameraToWorld},
      {"world_to_camera", io::PoseConvention::WorldToCamera},
      {"opengl", io::PoseConvention::OpenGl}};
  app.add_option(
         "--pose-convention", options.pose_convention,
         "what the poses of the recording mean: camera_to_world, world_to_camera (COLMAP), or opengl: camera to "
         "world of axes x right, y up, z backward (Blender, NeRF, ARKit)")
      ->transform(CLI::CheckedTransformer(conventions, CLI::ignore_case).description(""))
      ->type_name("TEXT");
}

void printWarnings(const std::string& tool, const std::vector<std::string>& warnings) {
  for (const std::string& warning : warnings) std::cerr << tool << ": warning: " << warning << std::endl;
}

std::unique_ptr<io::Recording> openRecording(const std::string& tool, const std::vector<std::string>& inputs,
                                             const io::RecordingOptions& options) {
  std::unique_ptr<io::Recording> recording = io::openRecording(inputs, options);
  printWarnings(tool, recording->warnings());
  return recording;
}

std::unique_ptr<io::Recording> openRecording(const std::string& tool, const std::vector<std::string>& inputs,
                                             const io::RecordingOptions& options, const io::StereoOptions& stereo) {
  std::unique_ptr<io::Recording> recording = io::withStereo(io::openRecording(inputs, options), inputs.front(), stereo);
  printWarnings(tool, recording->warnings());
  std::vector<bool> lacks_depth;
  for (std::size_t k = 0; k < recording->cameras().size(); ++k) lacks_depth.push_back(!recording->hasDepth(k));
  if (!stereo.estimate) warnOfMissingDepth(tool, lacks_depth);
  return recording;
}

void warnOfMissingDepth(const std::string& tool, const std::vector<bool>& lacks_depth) {
  const auto missing = std::count(lacks_depth.begin(), lacks_depth.end(), true);
  if (missing > 0)
    printWarnings(tool, {std::to_string(missing) + " of " + std::to_string(lacks_depth.size()) +
                         " cameras have colour images alone, no depth, and are missing"});
}

RecordingArguments::RecordingArguments(CLI::App& app) {
  input_ = app.add_option(
      "input", inputs_,
      "a rig recording (folder with rig.json), a 7-Scenes, TUM RGB-D, Redwood, MVSNet or COLMAP folder; files of one "
      "or more cameras: .mkv of Azure Kinect and Femto, bags of ROS and RealSense (.bag, .mcap, .db3), organised PCD; "
      "videos of colour cameras (.mp4, .mov, .avi, …)");
  app.add_option(
         "--views", options_.views,
         "frames that act as the cameras of one instant: 0,60,120 or A:B:STEP; of a rig recording, the cameras to use")
      ->multi_option_policy(CLI::MultiOptionPolicy::Join);
  app.add_option("--slide", options_.slide, "move those views on by this many frames, again and again")
      ->check(wholeNumber(0, std::numeric_limits<int>::max()));
  app.add_option("--depth-scale", options_.depth_scale, "metres per unit of depth, instead of the recording's own")
      ->check(positiveNumber());
  app.add_option("--poses", options_.poses,
                 "rig.json whose poses, depth and multipath corrections, and noise, replace the recording's, as "
                 "fuse_flow_calibrate writes it")
      ->check(path());
  app.add_option("--time-offsets", options_.time_offsets,
                 "of .mkv files and videos, in their order: by how many seconds each began later than the first moment "
                 "of all, as 0,0.4,1.2; default: what the files say, or all at the same moment")
      ->delimiter(',')
      ->check(numberFromTo(0, 1e6));
  addCalibrationOptions(app, options_);
}

io::RecordingOptions RecordingArguments::options() const {
  io::RecordingOptions result = options_;
  result.views = joinedList(result.views);
  return result;
}

}  // namespace fuse_flow::command_line
