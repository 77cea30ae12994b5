#include "io/file_io.h"
#include "io/readers.h"
#include "io/sequence_recording.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <map>
#include <sstream>

namespace fs = std::filesystem;

namespace fuse_flow::io {
namespace {

constexpr double max_time_difference = 0.02;  // seconds; the benchmark's own tools use the same

/** \brief The lines of "TIMESTAMP REST", by timestamp in seconds. */
std::map<double, std::string> readTimeline(const std::string& path) {
  std::map<double, std::string> entries;
  std::istringstream lines(readFile(path, kMostTextBytes));
  std::size_t line_number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++line_number;
    line.erase(line.find_last_not_of(" \t\r") + 1);  // npos + 1 is 0: a line of nothing but white space
    if (line.empty() || line[0] == '#') continue;
    std::istringstream words(line);
    double stamp = 0;
    std::string rest;
    if (!(words >> stamp) || !std::getline(words >> std::ws, rest))
      throw InputError(path + ": line " + std::to_string(line_number) + " is '" + cutShort(line) +
                       "', must begin with a timestamp");
    entries[stamp] = rest;
  }
  if (entries.empty()) throw InputError(path + ": has no entry");
  return entries;
}

/** \brief The entry nearest in time, or null if none is near enough. */
const std::pair<const double, std::string>* nearest(const std::map<double, std::string>& entries, double stamp) {
  auto best = entries.lower_bound(stamp);
  if (best == entries.end() || (best != entries.begin() && stamp - std::prev(best)->first < best->first - stamp))
    --best;
  return std::abs(best->first - stamp) <= max_time_difference ? &*best : nullptr;
}

/** \brief "tx ty tz qx qy qz qw": the colour camera's pose, metres; depth is registered to it. */
Eigen::Isometry3d parsePose(const std::string& path, const std::string& text) {
  std::istringstream words(text);
  double t[3], q[4];
  for (double& value : t) words >> value;
  for (double& value : q) words >> value;
  Eigen::Quaterniond rotation(q[3], q[0], q[1], q[2]);
  if (!words || std::abs(rotation.norm() - 1) > 1e-2)
    throw InputError(path + ": has '" + cutShort(text) +
                     "' after a timestamp, must be tx ty tz qx qy qz qw with a unit quaternion");
  rotation.normalize();
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = rotation.toRotationMatrix();
  T.translation() << t[0], t[1], t[2];
  return T;
}

/** \brief As the benchmark publishes them; its freiburg3 images are already undistorted. */
Intrinsics intrinsicsOf(const std::string& folder) {
  const std::size_t at = folder.rfind("freiburg");  // the last: folders above may name others
  const std::string camera = at == std::string::npos ? "" : folder.substr(at, 9);
  Intrinsics K;
  K.fx = K.fy = 525.0f;
  K.cx = 319.5f;
  K.cy = 239.5f;
  if (camera == "freiburg1") {
    K.fx = 517.306408f, K.fy = 516.469215f, K.cx = 318.643040f, K.cy = 255.313989f;
    K.distortion = {0.262383f, -0.953104f, -0.005358f, 0.002628f, 1.163314f};
  } else if (camera == "freiburg2") {
    K.fx = 520.908620f, K.fy = 521.007327f, K.cx = 325.141442f, K.cy = 249.701764f;
    K.distortion = {0.231222f, -0.784899f, -0.003257f, -0.000105f, 0.917205f};
  } else if (camera == "freiburg3") {
    K.fx = 535.433105f, K.fy = 539.212524f, K.cx = 320.106653f, K.cy = 247.632132f;
  }
  return K;
}

}  // namespace

bool isTumFolder(const std::string& folder) {
  return isThere((fs::path(folder) / "depth.txt").string()) && isThere((fs::path(folder) / "groundtruth.txt").string());
}

std::unique_ptr<Recording> openTum(const std::string& folder, const RecordingOptions& options) {
  const fs::path root(folder);
  const std::string pose_path = (root / "groundtruth.txt").string();
  const std::map<double, std::string> poses = readTimeline(pose_path);
  std::map<double, std::string> colors;
  if (isThere((root / "rgb.txt").string())) colors = readTimeline((root / "rgb.txt").string());

  Sequence sequence;
  sequence.kind = "tum";
  sequence.path = folder;
  for (const char* name : {"depth.txt", "rgb.txt", "groundtruth.txt", "depth", "rgb"})
    sequence.inputs.push_back((root / name).string());
  for (const char* list : {"depth.txt", "rgb.txt"})
    if (isThere((root / list).string()))
      for (const auto& [stamp, image] : readTimeline((root / list).string()))
        sequence.inputs.push_back((root / image).string());
  sequence.depth_scale = 1.0f / 5000;
  sequence.intrinsics = intrinsicsOf(fs::absolute(root).string());
  for (const auto& [stamp, depth] : readTimeline((root / "depth.txt").string())) {
    const auto* pose = nearest(poses, stamp);
    if (!pose) continue;  // the camera left the motion capture's sight
    SequenceFrame& frame = sequence.frames[sequence.frames.size()];
    frame.files.depth = (root / depth).string();
    if (const auto* color = colors.empty() ? nullptr : nearest(colors, stamp))
      frame.files.color = (root / color->second).string();
    frame.T_world_camera = parsePose(pose_path, pose->second);
    frame.stamp = static_cast<std::uint64_t>(std::llround(stamp * 1e6));
    frame.name = fs::path(depth).stem().string();
  }
  return openSequence(std::move(sequence), options);
}

}  // namespace fuse_flow::io
