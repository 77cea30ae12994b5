#include "io/calibration.h"
#include "io/file_io.h"
#include "io/json_file.h"
#include "io/readers.h"
#include "io/sequence_recording.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace fs = std::filesystem;

namespace fuse_flow::io {
namespace {

/** \brief A name that sorts by the value of the numbers in it, "2.png" before "10.png": each filled up with zeros. */
std::string sortKey(const std::string& name) {
  constexpr std::size_t digits = 20;
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  std::string key;
  for (auto at = name.begin(); at != name.end();) {
    const auto end = std::find_if_not(at, name.end(), is_digit);
    const std::string number(at, end);
    if (!number.empty() && number.size() < digits) key.append(digits - number.size(), '0');
    key += number;
    at = std::find_if(end, name.end(), is_digit);
    key.append(end, at);
  }
  return key;
}

/** \brief Files in folder with one of the extensions, in the order of their numbers. */
std::vector<std::string> findFiles(const fs::path& folder, const std::vector<std::string>& extensions) {
  std::vector<std::string> paths;
  for (const std::string& name : filesIn(folder.string()))
    if (std::find(extensions.begin(), extensions.end(), fs::path(name).extension().string()) != extensions.end())
      paths.push_back((folder / name).string());
  std::sort(paths.begin(), paths.end(), [](const std::string& a, const std::string& b) {
    return std::make_pair(sortKey(a), a) < std::make_pair(sortKey(b), b);
  });
  return paths;
}

/** \brief Open3D's samples keep odometry.log, which is of the same form, beside trajectory.log. */
std::string findTrajectory(const std::string& folder) {
  const std::vector<std::string> logs = findFiles(folder, {".log"});
  if (logs.size() == 1) return logs[0];
  const std::string usual = (fs::path(folder) / "trajectory.log").string();
  if (std::find(logs.begin(), logs.end(), usual) != logs.end()) return usual;
  throw InputError(folder + ": has " + std::to_string(logs.size()) +
                   " trajectories (.log), must be one, or one of them trajectory.log");
}

/** \brief Blocks of five lines: "i j k", then camera → world, 4×4; i is the frame's number. */
std::map<std::size_t, Eigen::Isometry3d> readTrajectory(const std::string& path) {
  const std::vector<double> numbers = readNumbers(path);
  constexpr std::size_t block = 3 + 16;
  if (numbers.empty() || numbers.size() % block != 0)
    throw InputError(path + ": has " + std::to_string(numbers.size()) +
                     " numbers, must be 19 a frame: three integers and a 4x4 pose");
  std::map<std::size_t, Eigen::Isometry3d> poses;
  for (auto at = numbers.begin(); at != numbers.end(); at += block) {
    if (!(at[0] >= 0 && at[0] <= 1e9 && at[0] == std::floor(at[0])))
      throw InputError(path + ": pose number " + std::to_string(poses.size()) + " has no frame number");
    const auto number = static_cast<std::size_t>(at[0]);
    poses[number] =
        rigidPose(path + ": pose of frame " + std::to_string(number), std::vector<double>(at + 3, at + block));
  }
  return poses;
}

/** \brief 0 if it is left out. */
int imageSide(const std::string& path, const nlohmann::json& json, const char* key) {
  const double side = json.value(key, 0.0);
  if (!(side >= 0 && side <= 65535 && side == std::floor(side)))
    throw InputError(path + ": " + key + " is " + json[key].dump() +
                     ", must be a whole number of pixels, 65535 at most");
  return static_cast<int>(side);
}

/** \brief Open3D's file: width, height and the 3×3 matrix column by column. */
bool readIntrinsicsJson(const std::string& path, Intrinsics& K) {
  const auto json = readJson<nlohmann::json>(path, "a camera as Open3D writes it");
  try {
    if (!json.is_object() || !json.contains("intrinsic_matrix")) return false;
    const auto matrix = json["intrinsic_matrix"].get<std::vector<float>>();
    if (matrix.size() != 9 || matrix[2] != 0 || matrix[5] != 0 || matrix[8] != 1)
      throw InputError(path + ": intrinsic_matrix must have 9 numbers, column by column: fx 0 0 0 fy 0 cx cy 1");
    for (const float skew : {matrix[1], matrix[3]})
      checkSkew(path, static_cast<double>(skew), static_cast<double>(matrix[0]));
    K.width = imageSide(path, json, "width");
    K.height = imageSide(path, json, "height");
    K.fx = matrix[0];
    K.fy = matrix[4];
    K.cx = matrix[6];
    K.cy = matrix[7];
    return true;
  } catch (const nlohmann::json::exception&) {
    throw InputError(path + ": is not a camera as Open3D writes it: width, height, intrinsic_matrix of 9 numbers");
  }
}

/** \brief \param used is set to the file that has them */
Intrinsics findIntrinsics(const std::string& folder, std::string& used) {
  Intrinsics K;
  for (const std::string& path : findFiles(folder, {".json"}))
    if (readIntrinsicsJson(used = path, K)) return K;
  throw InputError(folder +
                   ": has no camera intrinsics, expected a .json file with width, height and intrinsic_matrix");
}

}  // namespace

bool isRedwoodFolder(const std::string& folder) {
  return fs::is_directory(fs::path(folder) / "depth") && !findFiles(folder, {".log"}).empty();
}

std::unique_ptr<Recording> openRedwood(const std::string& folder, const RecordingOptions& options) {
  Sequence sequence;
  sequence.kind = "redwood";
  sequence.path = folder;
  sequence.intrinsics = findIntrinsics(folder, sequence.inputs.emplace_back());
  const std::string trajectory = findTrajectory(folder);
  const std::map<std::size_t, Eigen::Isometry3d> poses = readTrajectory(trajectory);

  for (const std::string& log : findFiles(folder, {".log"})) sequence.inputs.push_back(log);
  for (const char* images : {"depth", "color", "image"})
    sequence.inputs.push_back((fs::path(folder) / images).string());
  const std::vector<std::string> depths = findFiles(fs::path(folder) / "depth", {".png"});
  const bool is_color = fs::is_directory(fs::path(folder) / "color");
  const std::vector<std::string> colors =
      findFiles(fs::path(folder) / (is_color ? "color" : "image"), {".png", ".jpg", ".jpeg"});
  // Depth and colour files carry timestamps in their names that differ: they belong together by their order.
  for (std::size_t i = 0; i < depths.size(); ++i) {
    const auto pose = poses.find(i);
    if (pose == poses.end()) {
      sequence.unposed[i] = trajectory + ": has no pose of frame " + std::to_string(i) + ", " + depths[i] +
                            ", must have a block that begins with this number";
      continue;
    }
    SequenceFrame& frame = sequence.frames[i];
    frame.files.depth = depths[i];
    if (i < colors.size()) frame.files.color = colors[i];
    frame.T_world_camera = pose->second;
    frame.name = fs::path(depths[i]).stem().string();
  }
  return openSequence(std::move(sequence), options);
}

}  // namespace fuse_flow::io
