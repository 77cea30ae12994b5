#include "recordings/calibration.h"
#include "recordings/files/file_io.h"
#include "recordings/readers/photo_recording.h"
#include "recordings/readers/readers.h"

#include <filesystem>
#include <sstream>

namespace fs = std::filesystem;

namespace fuse_flow::io {
namespace {

constexpr const char* kCameraEnding = "_cam.txt";

/** \brief What the name of a camera's file shares with its images: "00000003" of 00000003_cam.txt; empty: it is no such file. */
std::string stemOf(const std::string& name) {
  const std::string ending = kCameraEnding;
  if (name.size() <= ending.size() || name.compare(name.size() - ending.size(), ending.size(), ending) != 0) return "";
  return name.substr(0, name.size() - ending.size());
}

/** \brief The first of some folders that is there; empty: none. */
std::string folderOf(const std::string& folder, const std::vector<const char*>& names) {
  std::error_code error;
  for (const char* name : names)
    if (const fs::path path = fs::path(folder) / name; fs::is_directory(path, error)) return path.string();
  return "";
}

/** \brief "extrinsic" and world → camera, 4×4; "intrinsic" and K, 3×3; then the range of depth, which is not needed. */
Camera readCameraFile(const std::string& path) {
  std::istringstream words(readFile(path, kMostTextBytes));
  const auto wrong = [&path](const std::string& what) {
    return InputError(path + ": " + what + ", must have 'extrinsic' and a 4x4 matrix, 'intrinsic' and a 3x3 matrix");
  };
  const auto matrixBehind = [&](const char* title, std::size_t n) {
    std::string word;
    words >> word;
    if (word != title) throw wrong("has no '" + std::string(title) + "'");
    std::vector<double> numbers(n);
    for (double& number : numbers)
      if (!(words >> number)) throw wrong("has too few numbers behind '" + std::string(title) + "'");
    return numbers;
  };
  const std::vector<double> extrinsic = matrixBehind("extrinsic", 16), intrinsic = matrixBehind("intrinsic", 9);
  Camera camera;
  camera.T_world_camera = nearlyRigidPose(path, extrinsic).inverse();
  camera.intrinsics = intrinsicsOf(path, intrinsic);
  return camera;
}

}  // namespace

bool isMvsnetFolder(const std::string& folder) {
  for (const std::string& name : filesIn((fs::path(folder) / "cams").string()))
    if (!stemOf(name).empty()) return true;
  return false;
}

std::unique_ptr<Recording> openMvsnet(const std::string& folder, const RecordingOptions& options) {
  Photos photos;
  photos.kind = "mvsnet";
  photos.path = folder;
  const std::string cams = (fs::path(folder) / "cams").string();
  const std::string depths = folderOf(folder, {"depth_est", "depths", "depth"});
  const std::string images = folderOf(folder, {"images", "image", "color"});
  const std::string confidences = folderOf(folder, {"confidence", "confidence_est", "conf"});
  for (const std::string& used : {cams, depths, images, confidences})
    if (!used.empty()) photos.inputs.push_back(used);
  if (depths.empty())
    throw InputError(folder +
                     ": has no depth maps; depth is not estimated here, must have depth_est/00000000.pfm beside cams");
  for (const std::string& name : filesIn(cams)) {
    const std::string stem = stemOf(name);
    if (stem.empty()) continue;
    Photo photo;
    photo.files.depth = findFloatImage(depths, stem);
    if (photo.files.depth.empty()) {
      ++photos.without_depth;
      continue;
    }
    photo.files.depth_was_there = true;
    if (!images.empty()) photo.files.color = findImage(images, stem);
    if (!confidences.empty()) photo.files.confidence = findFloatImage(confidences, stem);
    photo.camera = readCameraFile((fs::path(cams) / name).string());
    photo.camera.name = stem;
    photos.photos.push_back(std::move(photo));
  }
  return openPhotos(std::move(photos), options);
}

}  // namespace fuse_flow::io
