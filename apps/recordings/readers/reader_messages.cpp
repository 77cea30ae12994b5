#include "recordings/files/file_io.h"
#include "recordings/logs/message_log.h"
#include "recordings/messages/camera_topics.h"
#include "recordings/readers/readers.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

namespace fs = std::filesystem;

namespace fuse_flow::io {
namespace {

bool isLogFile(const std::string& path) {
  const std::string extension = fs::path(path).extension().string();
  return extension == ".bag" || extension == ".mcap" || extension == ".db3";
}

std::unique_ptr<MessageLog> openFile(const std::string& path) {
  const std::string extension = fs::path(path).extension().string();
  if (extension == ".bag") return openRosBag(path);
  return extension == ".mcap" ? openMcap(path) : openSqliteBag(path);
}

/** \brief The files of a ROS 2 bag, in their order: what its metadata.yaml lists, or, where the recorder was killed before it wrote that, those that are there. */
std::vector<std::string> filesOfBag(const std::string& folder) {
  const fs::path metadata = fs::path(folder) / "metadata.yaml";
  std::vector<std::string> files;
  if (isThere(metadata.string())) {
    try {
      const YAML::Node bag = YAML::Load(readFile(metadata.string(), kMostTextBytes))["rosbag2_bagfile_information"];
      for (const YAML::Node& file : bag["relative_file_paths"])
        files.push_back((fs::path(folder) / fs::path(file.as<std::string>()).filename()).string());
    } catch (const YAML::Exception& error) {
      throw InputError(metadata.string() + ": is not the metadata of a ROS 2 bag: " + error.what());
    }
  }
  if (files.empty())
    for (const std::string& name : filesIn(folder))
      if (fs::path(name).extension() == ".mcap" || fs::path(name).extension() == ".db3")
        files.push_back((fs::path(folder) / name).string());
  return files;
}

std::unique_ptr<MessageLog> openLog(const std::string& path, std::vector<std::string>& files) {
  if (!fs::is_directory(path)) {
    files.push_back(path);
    return openFile(path);
  }
  std::vector<std::unique_ptr<MessageLog>> parts;
  for (const std::string& file : filesOfBag(path)) {
    if (fs::path(file).extension() == ".zstd")
      throw InputError(file + ": the whole file is compressed; `unzstd " + file + "` makes one that can be read");
    parts.push_back(openFile(file));
  }
  files.push_back(path);
  if (parts.size() == 1) return std::move(parts[0]);
  return joinLogs(path, std::move(parts));
}

/** \brief A tree of frames is of one log. Cameras of several stand in one world only if its name is the same, and nobody has recorded a camera of that name twice. */
void forgetStrangersPoses(std::vector<RecordedCamera>& cameras) {
  std::set<std::string> worlds, files;
  std::map<std::string, int> names;
  for (const RecordedCamera& recorded : cameras) {
    worlds.insert(recorded.world);
    files.insert(recorded.file);
    ++names[recorded.frame];
  }
  const bool twice = std::any_of(names.begin(), names.end(), [](const auto& name) { return name.second > 1; });
  if (worlds.size() == 1 && (files.size() == 1 || !twice)) return;
  for (RecordedCamera& recorded : cameras) {
    recorded.posed = false;
    recorded.camera.T_world_camera.setIdentity();
  }
}

}  // namespace

bool isMessageLog(const std::string& path) {
  std::error_code error;
  if (!fs::is_directory(path, error)) return isLogFile(path);
  return isThere((fs::path(path) / "metadata.yaml").string()) || !filesOfBag(path).empty();
}

std::unique_ptr<Recording> openMessageLogs(const std::vector<std::string>& paths, const RecordingOptions& options) {
  std::vector<RecordedCamera> cameras;
  std::vector<std::string> warnings, files;
  std::string kind;
  for (const std::string& path : paths) {
    std::shared_ptr<MessageLog> log = openLog(path, files);
    warnings.insert(warnings.end(), log->warnings().begin(), log->warnings().end());
    const std::string name = cameraName(path, paths);
    std::vector<RecordedCamera> found = camerasOf(log, name, options.read_color, warnings);
    for (RecordedCamera& camera : found) {
      if (paths.size() > 1 && found.size() > 1) camera.camera.name = name + "_" + camera.camera.name;
      cameras.push_back(std::move(camera));
    }
  }
  forgetStrangersPoses(cameras);
  return openRecordedCameras("bag", std::move(cameras), std::move(files), std::move(warnings), options);
}

}  // namespace fuse_flow::io
