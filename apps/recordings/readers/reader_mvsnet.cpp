#include "recordings/calibrations/calibration.h"
#include "recordings/files/file_io.h"
#include "recordings/images/float_image.h"
#include "recordings/readers/photo_recording.h"
#include "recordings/readers/readers.h"

#include <algorithm>
#include <filesystem>
#include <sstream>

namespace fs = std::filesystem;

namespace fuse_flow::io {
namespace {

constexpr const char* kCameraEnding = "_cam.txt";
const std::vector<const char*> kDepthFolders = {"depth_est", "depths", "depth"};

/** \brief What the name of a camera's file shares with its images: "00000003" of 00000003_cam.txt; empty: it is no such file. */
std::string stemOf(const std::string& name) {
  const std::string ending = kCameraEnding;
  if (name[0] == '.' || name.size() <= ending.size() ||
      name.compare(name.size() - ending.size(), ending.size(), ending) != 0)
    return "";
  return name.substr(0, name.size() - ending.size());
}

/** \brief The first of some folders that is there and not empty; empty: none. */
std::string folderOf(const std::string& folder, const std::vector<const char*>& names) {
  for (const char* name : names)
    if (const std::string path = (fs::path(folder) / name).string(); !filesIn(path).empty()) return path;
  return "";
}

/** \brief "extrinsic" and world → camera, 4×4; "intrinsic" and K, 3×3; then the range of depth, which is not needed. */
Camera readCameraFile(const std::string& path) {
  std::istringstream words(readText(path, kMostCalibrationBytes));
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

/** \brief Depth whose camera is not there is not used. */
void warnOfOrphans(const std::string& depths, Photos& photos) {
  std::size_t files = 0;
  for (const std::string& name : filesIn(depths)) files += name[0] != '.' && isFloatImage(name) ? 1 : 0;
  const auto used = static_cast<std::size_t>(
      std::count_if(photos.photos.begin(), photos.photos.end(), [](const Photo& p) { return !p.files.depth.empty(); }));
  if (files > used)
    photos.warnings.push_back(depths + ": " + std::to_string(files - used) + " of " + std::to_string(files) +
                              " depth maps have no camera in cams, or another beside them, and are left out");
}

}  // namespace

bool isMvsnetFolder(const std::string& folder) {
  // Some write cams into COLMAP's workspace, whose depth lies elsewhere.
  if (isColmapFolder(folder) && isThere((fs::path(folder) / "stereo" / "depth_maps").string()) &&
      folderOf(folder, kDepthFolders).empty())
    return false;
  for (const std::string& name : filesIn((fs::path(folder) / "cams").string()))
    if (!stemOf(name).empty()) return true;
  return false;
}

std::unique_ptr<Recording> openMvsnet(const std::string& folder, const RecordingOptions& options) {
  Photos photos;
  photos.kind = "mvsnet";
  photos.scaled_from_first_middle = true;
  photos.path = folder;
  const std::string cams = (fs::path(folder) / "cams").string();
  const std::string depths = folderOf(folder, kDepthFolders);
  const std::string images = folderOf(folder, {"images", "image", "color"});
  const std::string confidences = folderOf(folder, {"confidence", "confidence_est", "conf"});
  photos.color_folder = images;
  photos.confidence_folder = confidences;
  for (const std::string& used : {cams, depths, images, confidences})
    if (!used.empty()) photos.inputs.push_back(used);
  for (const std::string& name : filesIn(cams)) {
    const std::string stem = stemOf(name);
    if (stem.empty()) continue;
    Photo photo;
    if (!depths.empty()) photo.files.depth = findFloatImage(depths, stem);
    photo.files.depth_was_there = !photo.files.depth.empty();
    if (!images.empty()) photo.files.color = findImage(images, stem);
    if (!confidences.empty()) photo.files.confidence = findConfidence(confidences, stem);
    photo.camera = readCameraFile((fs::path(cams) / name).string());
    photo.camera.name = stem;
    photos.photos.push_back(std::move(photo));
  }
  if (!depths.empty() && !haveDepth(photos.photos))
    throw InputError(depths +
                     ": has no depth map of the cameras in cams, must have one named such as 00000000.pfm or "
                     ".npy for 00000000_cam.txt");
  if (!depths.empty()) warnOfOrphans(depths, photos);
  return openPhotos(std::move(photos), options);
}

}  // namespace fuse_flow::io
