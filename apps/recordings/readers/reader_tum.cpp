#include "recordings/files/cut_short.h"
#include "recordings/files/file_io.h"
#include "recordings/image_folders/stamp_unit.h"
#include "recordings/readers/readers.h"
#include "recordings/readers/sequence_recording.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <map>
#include <optional>
#include <sstream>

namespace fs = std::filesystem;

namespace fuse_flow::io {
namespace {

constexpr Nanoseconds max_time_difference = 20'000'000;  // 20 ms; the benchmark's own tools use the same

/** \brief The lines of "TIMESTAMP REST", by time stamp. */
struct Timeline {
  std::map<Nanoseconds, std::string> entries;
  std::string unit;  ///< of the file's stamps
};

Timeline readTimeline(const std::string& path) {
  Timeline timeline;
  std::vector<std::pair<long double, std::string>> lines_read;
  std::istringstream lines(readText(path));
  std::size_t line_number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++line_number;
    line.erase(line.find_last_not_of(" \t\r") + 1);  // npos + 1 is 0: a line of nothing but white space
    if (line.empty() || line[0] == '#') continue;
    std::istringstream words(line);
    long double stamp = 0;
    std::string rest;
    if (!(words >> stamp) || !(stamp >= 0) || !std::getline(words >> std::ws, rest))
      throw InputError(path + ": line " + std::to_string(line_number) + " is '" + cutShort(line) +
                       "', must begin with a timestamp");
    lines_read.emplace_back(stamp, rest);
  }
  if (lines_read.empty()) throw InputError(path + ": has no entry");
  const auto later = [](const auto& a, const auto& b) { return a.first < b.first; };
  const StampUnit unit = stampUnit(std::max_element(lines_read.begin(), lines_read.end(), later)->first);
  timeline.unit = unit.name;
  for (auto& [stamp, rest] : lines_read) {
    const std::optional<Nanoseconds> time = inNanoseconds(stamp, unit);
    if (!time) throw InputError(path + ": the timestamp of '" + cutShort(rest) + "' is no time in " + unit.name);
    timeline.entries[*time] = rest;
  }
  return timeline;
}

/** \brief The entry nearest in time, or null if none is near enough. */
const std::pair<const Nanoseconds, std::string>* nearest(const std::map<Nanoseconds, std::string>& entries,
                                                         Nanoseconds stamp) {
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
  const bool finite = std::isfinite(t[0]) && std::isfinite(t[1]) && std::isfinite(t[2]);
  if (!words || !finite || !(std::abs(rotation.norm() - 1) <= 1e-2))
    throw InputError(path + ": has '" + cutShort(text) +
                     "' after a timestamp, must be tx ty tz qx qy qz qw with a unit quaternion");
  rotation.normalize();
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = rotation.toRotationMatrix();
  T.translation() << t[0], t[1], t[2];
  return T;
}

/** \brief freiburg1, 2 or 3, if the folder's path names one: the last, since folders above may name others. */
std::string datasetCamera(const std::string& folder) {
  const std::size_t at = folder.rfind("freiburg");
  return at == std::string::npos ? "" : folder.substr(at, 9);
}

/** \brief As the benchmark publishes them; its freiburg3 images are already undistorted. */
Intrinsics datasetIntrinsics(const std::string& camera) {
  Intrinsics K;
  K.width = 640;
  K.height = 480;
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
  const std::string pose_path = (root / "groundtruth.txt").string(), depth_path = (root / "depth.txt").string();
  const Timeline poses = readTimeline(pose_path), depths = readTimeline(depth_path);
  Timeline colors;
  if (isThere((root / "rgb.txt").string())) colors = readTimeline((root / "rgb.txt").string());

  Sequence sequence;
  sequence.kind = "tum";
  sequence.color_expected = "listed in rgb.txt, with times within 20 ms of those of depth.txt";
  sequence.path = folder;
  for (const char* name : {"depth.txt", "rgb.txt", "groundtruth.txt", "depth", "rgb"})
    sequence.inputs.push_back((root / name).string());
  for (const Timeline* timeline : std::initializer_list<const Timeline*>{&depths, &colors})
    for (const auto& [stamp, image] : timeline->entries) sequence.inputs.push_back((root / image).string());
  sequence.depth_scale = 1.0f / 5000;
  const std::string camera = datasetCamera(fs::absolute(root).string());
  sequence.usual_intrinsics = datasetIntrinsics(camera);
  sequence.usual_camera = "a Kinect (fx 525)";
  sequence.usual_certain = camera == "freiburg1" || camera == "freiburg2" || camera == "freiburg3";
  if (depths.unit != "seconds")
    sequence.warnings.push_back(depth_path + ": its time stamps are taken for " + depths.unit +
                                ", since in seconds they would be no date");
  std::size_t without_pose = 0, number = 0;
  for (const auto& [stamp, depth] : depths.entries) {
    const auto* pose = nearest(poses.entries, stamp);
    if (!pose) {  // the camera left the motion capture's sight
      ++without_pose;
      continue;
    }
    SequenceFrame frame;
    frame.files.depth = (root / depth).string();
    if (const auto* color = colors.entries.empty() ? nullptr : nearest(colors.entries, stamp))
      frame.files.color = (root / color->second).string();
    frame.stamp = static_cast<std::uint64_t>((stamp + 500) / 1000);
    frame.name = fs::path(depth).stem().string();
    try {
      frame.T_world_camera = parsePose(pose_path, pose->second);
      sequence.frames[number++] = std::move(frame);
    } catch (const InputError& error) {  // where tracking was lost; an error only if this frame is selected
      sequence.unposed[number++] = error.what();
    }
  }
  if (without_pose > 0)
    sequence.warnings.push_back(std::to_string(without_pose) + " of " + std::to_string(depths.entries.size()) +
                                " images of " + depth_path + " are left out: " + pose_path +
                                " has no pose within 20 ms of them");
  return openSequence(std::move(sequence), options);
}

}  // namespace fuse_flow::io
