#include "recordings/calibrations/calibration.h"
#include "recordings/files/file_io.h"
#include "recordings/readers/readers.h"
#include "recordings/readers/sequence_recording.h"

#include <filesystem>
#include <regex>

namespace fs = std::filesystem;

namespace fuse_flow::io {
namespace {

/** \brief The numbers of all frame-NNNNNN.ENDING, with what their names share. */
std::map<std::size_t, std::string> findFrames(const std::string& folder, const std::string& ending) {
  const std::regex frame_name(R"((frame-(\d{6}|[1-9]\d{6,8}))\.)" + ending);
  std::map<std::size_t, std::string> stems;
  for (const std::string& name : filesIn(folder)) {
    std::smatch match;
    if (std::regex_match(name, match, frame_name)) stems[std::stoul(match[2])] = match[1];
  }
  return stems;
}

std::map<std::size_t, std::string> findPoses(const std::string& folder) { return findFrames(folder, R"(pose\.txt)"); }

/** \brief The depth camera as the dataset's page gives it. */
Intrinsics datasetIntrinsics() {
  Intrinsics K;
  K.width = 640;
  K.height = 480;
  K.fx = K.fy = 585;
  K.cx = 320;
  K.cy = 240;
  return K;
}

}  // namespace

bool isSevenScenesFolder(const std::string& folder) { return !findPoses(folder).empty(); }

std::unique_ptr<Recording> openSevenScenes(const std::string& folder, const RecordingOptions& options) {
  Sequence sequence;
  sequence.kind = "seven_scenes";
  sequence.color_expected = "named like frame-000000.color.png, or .jpg";
  sequence.path = folder;
  sequence.usual_intrinsics = datasetIntrinsics();
  sequence.usual_camera = "7-Scenes' Kinect (fx 585)";
  for (const std::string& name : filesIn(folder))
    if (name.rfind("frame-", 0) == 0) sequence.inputs.push_back((fs::path(folder) / name).string());
  for (const auto& [number, stem] : findPoses(folder)) {
    const std::string prefix = (fs::path(folder) / stem).string();
    SequenceFrame frame;
    frame.name = stem;
    frame.files.depth = prefix + ".depth.png";
    frame.files.color = findImage(folder, stem + ".color");
    try {
      frame.T_world_camera = readPose(prefix + ".pose.txt");
    } catch (const InputError& error) {  // where tracking was lost; an error only if this frame is selected
      sequence.unposed[number] = error.what();
      continue;
    }
    sequence.frames[number] = std::move(frame);
  }
  const std::map<std::size_t, std::string> depths = findFrames(folder, R"(depth\.png)");
  for (auto& [number, frame] : sequence.frames) frame.files.depth_was_there = depths.count(number) > 0;
  for (const auto& [number, stem] : depths)
    if (sequence.frames.count(number) == 0 && sequence.unposed.count(number) == 0)
      sequence.unposed[number] = (fs::path(folder) / stem).string() + ".pose.txt: not found, must hold the pose of " +
                                 stem + ".depth.png, 4x4, row by row";
  return openSequence(std::move(sequence), options);
}

}  // namespace fuse_flow::io
