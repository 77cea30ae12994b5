#include "clouds/plain_clouds.h"

#include "clouds/cloud_io.h"
#include "recordings/files/file_io.h"
#include "recordings/files/pcd_file.h"
#include "recordings/image_folders/name_number.h"
#include "recordings/readers/readers.h"
#include "recordings/streams/recorded_camera.h"

#include <fuse_flow/recordings/error.h>
#include <fuse_flow/recordings/rig_json.h>

#include <pcl/common/transforms.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <set>

namespace fs = std::filesystem;

namespace fuse_flow::io {
namespace {

bool hasExtension(const std::string& path, const char* extension) {
  std::string own = fs::path(path).extension().string();
  std::transform(own.begin(), own.end(), own.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return own == extension;
}

bool isLiveScan(const std::string& path) {
  return hasExtension(path, ".bin") && isThere(path) && LiveScanFile::is(path);
}

bool isCloudFile(const std::string& path) { return hasExtension(path, ".ply") || hasExtension(path, ".pcd"); }

/** \brief A PCD file's header says whether its points are the pixels of an image. */
bool isOrganizedPcd(const std::string& path) {
  if (!hasExtension(path, ".pcd")) return false;
  constexpr std::uint64_t most = 4096;  // of a header
  const std::string head = readFileStart(path, most);
  const std::size_t height = head.find("\nHEIGHT ");
  return height != std::string::npos && std::strtol(head.c_str() + height + 8, nullptr, 10) > 1;
}

/** \brief The clouds of a folder by the last number in their names. */
std::map<std::size_t, std::string> cloudsIn(const std::string& folder) {
  std::map<std::size_t, std::string> clouds;
  for (const std::string& name : filesIn(folder)) {
    if (!isCloudFile(name)) continue;
    const std::vector<std::size_t> numbers = numbersIn(fs::path(name).stem().string());
    if (numbers.empty()) continue;
    const auto [known, added] = clouds.emplace(numbers.back(), (fs::path(folder) / name).string());
    if (!added)
      throw InputError(folder + ": has " + fs::path(known->second).filename().string() + " and " + name +
                       ", must have one cloud of a frame");
  }
  return clouds;
}

bool hasField(const pcl::PCLPointCloud2& cloud, const char* name) {
  return std::any_of(cloud.fields.begin(), cloud.fields.end(),
                     [&](const pcl::PCLPointField& field) { return field.name == name; });
}

}  // namespace

bool PlainClouds::are(const std::vector<std::string>& inputs) {
  std::error_code error;
  return !inputs.empty() && std::all_of(inputs.begin(), inputs.end(), [&](const std::string& input) {
    if (!fs::is_directory(input, error))
      return isLiveScan(input) || (isCloudFile(input) && isThere(input) && !isOrganizedPcd(input));
    if (isRecordingFolder(input)) return false;  // whatever clouds lie in it
    const std::map<std::size_t, std::string> clouds = cloudsIn(input);
    return !clouds.empty() && !isOrganizedPcd(clouds.begin()->second);
  });
}

PlainClouds::PlainClouds(const std::vector<std::string>& inputs, const std::string& poses)
    : inputs_(inputs), poses_(poses) {
  std::error_code error;
  const bool folders = fs::is_directory(inputs[0], error);
  for (const std::string& input : inputs) {
    if (fs::is_directory(input, error) != folders)
      throw InputError(input + ": inputs must all be files, or all be folders, one for each scanner");
    names_.push_back(folders ? fs::path(fs::absolute(input)).lexically_normal().filename().string()
                             : cameraName(input, inputs));
    if (names_.back().empty()) names_.back() = fs::absolute(input).lexically_normal().parent_path().filename().string();
    files_.push_back(folders ? cloudsIn(input) : std::map<std::size_t, std::string>{{0, input}});
    livescan_.push_back(isLiveScan(input) ? std::make_unique<LiveScanFile>(input) : nullptr);
    if (!livescan_.back()) continue;
    for (std::size_t k = 1; k < livescan_.back()->frameCount(); ++k) files_.back()[k] = input;
    if (livescan_.back()->isCutShort()) warnings_.push_back(input + ": its last frame is cut short, and is left out");
  }
  checkLiveScan();
  placeScanners();
  if (livescan_[0]) return;  // whose points have no normals
  pcl::PCLPointCloud2 first;
  readCloud(files_[0].begin()->second, first, EmptyCloud::Accepted);
  have_normals_ = hasField(first, "normal_x");
}

void PlainClouds::checkLiveScan() {
  for (std::size_t k = 0; k < inputs_.size(); ++k)
    if ((livescan_[k] != nullptr) != (livescan_[0] != nullptr))
      throw InputError(inputs_[k] + ": inputs must all be files of LiveScan3D, or none");
  const auto differs =
      std::find_if(files_.begin(), files_.end(), [&](const auto& files) { return files.size() != files_[0].size(); });
  if (!livescan_[0] || differs == files_.end()) return;
  warnings_.push_back(inputs_[0] + " has " + std::to_string(files_[0].size()) + " frames, " +
                      inputs_[static_cast<std::size_t>(differs - files_.begin())] + " " +
                      std::to_string(differs->size()) +
                      "; those of the same place are taken to be of one instant, from the first on");
}

void PlainClouds::placeScanners() {
  T_world_scanner_.assign(inputs_.size(), Eigen::Isometry3d::Identity());
  if (poses_.empty()) return;
  const RigDescription rig = readRigJson(poses_);
  for (std::size_t k = 0; k < names_.size(); ++k) {
    const auto found = std::find_if(rig.cameras.begin(), rig.cameras.end(),
                                    [&](const RigCamera& entry) { return entry.camera.name == names_[k]; });
    if (found == rig.cameras.end())
      throw InputError(poses_ + ": has no camera '" + names_[k] + "', as the clouds of " + inputs_[k] + " are called");
    T_world_scanner_[k] = found->camera.T_world_camera;
  }
}

std::vector<std::size_t> PlainClouds::frames() const {
  std::set<std::size_t> numbers;
  for (const auto& files : files_)
    for (const auto& [number, file] : files) numbers.insert(number);
  return std::vector<std::size_t>(numbers.begin(), numbers.end());
}

std::vector<std::string> PlainClouds::inputs() const {
  std::vector<std::string> all = inputs_;
  if (!poses_.empty()) all.push_back(poses_);
  return all;
}

void PlainClouds::read(std::size_t frame, pcl::PointCloud<PointFusedNormal>& points,
                       std::vector<std::uint32_t>& scanners) {
  points.clear();
  scanners.clear();
  for (std::size_t k = 0; k < files_.size(); ++k) {
    const auto file = files_[k].find(frame);
    if (file == files_[k].end()) continue;  // this scanner has lost the frame
    pcl::PointCloud<PointFusedNormal> own;  // a new one: what a file lacks must not be another one's
    if (livescan_[k])
      livescan_[k]->read(frame, own);
    else
      readPointsOf(file->second, own);
    pcl::transformPointCloudWithNormals(own, own, T_world_scanner_[k].cast<float>().matrix());
    points += own;
    scanners.insert(scanners.end(), own.size(), static_cast<std::uint32_t>(k));
  }
}

void PlainClouds::readPointsOf(const std::string& file, pcl::PointCloud<PointFusedNormal>& points) const {
  pcl::PCLPointCloud2 blob;
  readCloud(file, blob, EmptyCloud::Accepted);
  const bool colored = hasField(blob, "rgb") || hasField(blob, "rgba"), sure = hasField(blob, "confidence");
  if (hasField(blob, "normal_x") != have_normals_)
    throw InputError(file + (have_normals_ ? ": has no normals, others have them" : ": has normals, others have none") +
                     "; all clouds must, or none");
  {
    const SilencePcl silence;
    pcl::fromPCLPointCloud2(blob, points);
  }
  for (PointFusedNormal& point : points) {
    if (!sure) point.confidence = 1;
    if (!colored) point.r = point.g = point.b = 255;
  }
}

}  // namespace fuse_flow::io
