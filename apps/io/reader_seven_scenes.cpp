#include "io/calibration.h"
#include "io/file_io.h"
#include "io/readers.h"
#include "io/sequence_recording.h"

#include <filesystem>
#include <regex>
#include <sstream>

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

Intrinsics readIntrinsics(const std::string& path) {
  Intrinsics K;
  K.fx = K.fy = 585;  // the depth camera as the dataset's page gives it
  K.cx = 320;
  K.cy = 240;
  if (!isThere(path)) return K;
  const std::vector<double> numbers = readNumbers(path);
  if (numbers.size() != 9)
    throw InputError(path + ": has " + std::to_string(numbers.size()) +
                     " numbers, must be 9: a 3x3 matrix, row by row");
  if (numbers[6] != 0 || numbers[7] != 0 || numbers[8] != 1) {
    std::ostringstream row;
    row << numbers[6] << ' ' << numbers[7] << ' ' << numbers[8];
    throw InputError(path + ": the last row is " + row.str() + ", must be 0 0 1");
  }
  for (const double skew : {numbers[1], numbers[3]}) checkSkew(path, skew, numbers[0]);
  K.fx = static_cast<float>(numbers[0]);
  K.fy = static_cast<float>(numbers[4]);
  K.cx = static_cast<float>(numbers[2]);
  K.cy = static_cast<float>(numbers[5]);
  return K;
}

}  // namespace

bool isSevenScenesFolder(const std::string& folder) { return !findPoses(folder).empty(); }

std::unique_ptr<Recording> openSevenScenes(const std::string& folder, const RecordingOptions& options) {
  Sequence sequence;
  sequence.kind = "seven_scenes";
  sequence.path = folder;
  sequence.intrinsics = readIntrinsics((fs::path(folder) / "camera-intrinsics.txt").string());
  sequence.inputs.push_back((fs::path(folder) / "camera-intrinsics.txt").string());
  for (const std::string& name : filesIn(folder))
    if (name.rfind("frame-", 0) == 0) sequence.inputs.push_back((fs::path(folder) / name).string());
  for (const auto& [number, stem] : findPoses(folder)) {
    const std::string prefix = (fs::path(folder) / stem).string();
    SequenceFrame& frame = sequence.frames[number];
    frame.name = stem;
    frame.files.depth = prefix + ".depth.png";
    frame.files.color = findImage(folder, stem + ".color");
    frame.T_world_camera = readPose(prefix + ".pose.txt");
  }
  for (const auto& [number, stem] : findFrames(folder, R"(depth\.png)"))
    if (sequence.frames.count(number) == 0)
      sequence.unposed[number] = (fs::path(folder) / stem).string() + ".pose.txt: not found, must hold the pose of " +
                                 stem + ".depth.png, 4x4, row by row";
  return openSequence(std::move(sequence), options);
}

}  // namespace fuse_flow::io
