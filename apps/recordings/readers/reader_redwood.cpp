#include "recordings/calibrations/intrinsics_file.h"
#include "recordings/files/file_io.h"
#include "recordings/image_folders/name_number.h"
#include "recordings/readers/readers.h"
#include "recordings/readers/sequence_recording.h"
#include "recordings/readers/trajectory_file.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>

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

/** \brief A .log, if there is one, else Open3D's .json. Open3D's samples keep odometry.log, which is of the same form, beside trajectory.log. */
std::string findTrajectory(const std::string& folder) {
  const std::vector<std::string> logs = findFiles(folder, {".log"});
  if (logs.empty()) return (fs::path(folder) / kOpen3dTrajectory).string();
  if (logs.size() == 1) return logs[0];
  const std::string usual = (fs::path(folder) / "trajectory.log").string();
  if (std::find(logs.begin(), logs.end(), usual) != logs.end()) return usual;
  throw InputError(folder + ": has " + std::to_string(logs.size()) +
                   " trajectories (.log), must be one, or one of them trajectory.log");
}

/** \brief The number of a frame: the only one in its name, or the first of NUMBER-TIME as Redwood writes it, which counts from 1. */
std::optional<std::size_t> frameNumber(const std::string& path, bool from_one) {
  const std::vector<std::size_t> numbers = numbersIn(fs::path(path).stem().string());
  if (numbers.empty() || (from_one && numbers[0] == 0)) return std::nullopt;
  return from_one ? numbers[0] - 1 : numbers[0];
}

bool allNameNumberAndTime(const std::vector<std::string>& paths) {
  return std::all_of(paths.begin(), paths.end(), [](const std::string& path) {
    const std::vector<std::size_t> numbers = numbersIn(fs::path(path).stem().string());
    return numbers.size() == 2 && numbers[0] > 0;
  });
}

/** \brief Images by their number, each once; none where a name has no number, or two have the same. */
std::optional<std::map<std::size_t, std::string>> byNumber(const std::vector<std::string>& paths, bool from_one) {
  std::map<std::size_t, std::string> result;
  for (const std::string& path : paths) {
    const std::optional<std::size_t> number = frameNumber(path, from_one);
    if (!number || !result.emplace(*number, path).second) return std::nullopt;
  }
  return result;
}

std::map<std::size_t, std::string> byPlace(const std::vector<std::string>& paths) {
  std::map<std::size_t, std::string> result;
  for (std::size_t i = 0; i < paths.size(); ++i) result[i] = paths[i];
  return result;
}

/** \brief Whether numbers are 1 … n, where the trajectory's are 0 … n − 1. */
bool countFromOne(const std::map<std::size_t, std::string>& images,
                  const std::map<std::size_t, Eigen::Isometry3d>& poses) {
  return !images.empty() && images.begin()->first == 1 && images.rbegin()->first == images.size() &&
         poses.size() == images.size() && poses.begin()->first == 0 && poses.rbegin()->first + 1 == poses.size();
}

/** \brief Depth and colour images by the number of their frame, and what is to be said of how it was found. */
struct Images {
  std::map<std::size_t, std::string> depth, color;
  std::vector<std::string> warnings;
};

Images numberImages(const std::string& folder, const std::vector<std::string>& depths,
                    const std::vector<std::string>& colors, const std::map<std::size_t, Eigen::Isometry3d>& poses) {
  Images images;
  bool from_one = allNameNumberAndTime(depths);
  auto depth = byNumber(depths, from_one);
  if (depth && !from_one && countFromOne(*depth, poses)) {
    from_one = true;
    depth = byNumber(depths, true);
    images.warnings.push_back(folder + ": its images count from 1, its trajectory from 0: image 1 gets pose 0");
  }
  const bool any_pose = depth && std::any_of(depth->begin(), depth->end(),
                                             [&](const auto& image) { return poses.count(image.first) > 0; });
  if (any_pose) {
    images.depth = *depth;
    // Colour may be named otherwise than depth, as long as its names have the same numbers.
    if (auto color = byNumber(colors, from_one))
      images.color = std::move(*color);
    else if (!colors.empty())
      images.warnings.push_back(folder +
                                ": colour images are not used, their names do not tell which depth image each "
                                "belongs to, such as " +
                                colors[0]);
    return images;
  }
  images.depth = byPlace(depths);
  images.warnings.push_back(folder +
                            ": the names of its depth images tell no numbers of the trajectory; they get its "
                            "poses in their order");
  if (colors.size() == depths.size())
    images.color = byPlace(colors);
  else if (!colors.empty())
    images.warnings.push_back(folder + ": colour images are not used, " + std::to_string(colors.size()) + " beside " +
                              std::to_string(depths.size()) +
                              " depth images, and no numbers say which belong together");
  return images;
}

}  // namespace

bool isRedwoodFolder(const std::string& folder) {
  const fs::path root(folder);
  return fs::is_directory(root / "depth") &&
         (!findFiles(folder, {".log"}).empty() || isThere((root / kOpen3dTrajectory).string()));
}

std::unique_ptr<Recording> openRedwood(const std::string& folder, const RecordingOptions& options) {
  Sequence sequence;
  sequence.kind = "redwood";
  sequence.path = folder;
  const std::string trajectory_path = findTrajectory(folder);
  const bool json = fs::path(trajectory_path).extension() == ".json";
  const Trajectory trajectory = json ? readTrajectoryJson(trajectory_path) : readTrajectoryLog(trajectory_path);
  for (const std::string& file : findFiles(folder, {".log"})) sequence.inputs.push_back(file);
  for (const std::string& file : findFiles(folder, {".json"}))  // but for a report of a tool, say
    if (readFile(file, kMostTextBytes).find("intrinsic_matrix") != std::string::npos) sequence.inputs.push_back(file);
  for (const char* images : {"depth", "color", "rgb", "image"})
    sequence.inputs.push_back((fs::path(folder) / images).string());
  const std::vector<std::string> depths = findFiles(fs::path(folder) / "depth", {".png"});
  const std::string color_folder = colorFolder(folder);
  std::vector<std::string> colors;
  if (!color_folder.empty()) colors = findFiles(color_folder, {".png", ".jpg", ".jpeg"});
  if (colors.empty()) sequence.color_expected = "in a folder color, rgb or image beside depth";
  Images images = numberImages(folder, depths, colors, trajectory.poses);
  sequence.warnings = std::move(images.warnings);
  if (const std::string other = (fs::path(folder) / kOpen3dTrajectory).string(); !json && isThere(other))
    sequence.warnings.push_back(other + ": is not used, the poses are those of " + trajectory_path);
  for (const auto& [number, depth] : images.depth) {
    if (const auto invalid = trajectory.invalid.find(number); invalid != trajectory.invalid.end()) {
      sequence.unposed[number] = invalid->second;
      continue;
    }
    const auto pose = trajectory.poses.find(number);
    if (pose == trajectory.poses.end()) {
      sequence.unposed[number] =
          trajectory_path + ": has no pose of frame " + std::to_string(number) + ", " + depth +
          (json ? ", must have an entry for each frame, from 0" : ", must have a block that begins with this number");
      continue;
    }
    SequenceFrame& frame = sequence.frames[number];
    frame.files.depth = depth;
    frame.files.depth_was_there = true;
    if (const auto color = images.color.find(number); color != images.color.end()) frame.files.color = color->second;
    frame.T_world_camera = pose->second;
    frame.name = fs::path(depth).stem().string();
  }
  return openSequence(std::move(sequence), options);
}

}  // namespace fuse_flow::io
