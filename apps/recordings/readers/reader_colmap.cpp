#include "recordings/calibrations/calibration.h"
#include "recordings/calibrations/colmap_camera.h"
#include "recordings/files/file_io.h"
#include "recordings/readers/photo_recording.h"
#include "recordings/readers/readers.h"

#include <Eigen/Geometry>

#include <cctype>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>
#include <sstream>

namespace fs = std::filesystem;

namespace fuse_flow::io {
namespace {

using Cameras = std::map<std::uint32_t, Intrinsics>;

/** \brief A photograph as COLMAP lists it. */
struct Registered {
  std::string name;
  std::uint32_t camera{0};
  Eigen::Isometry3d T_camera_world = Eigen::Isometry3d::Identity();
};

/** \brief The numbers of a binary file, one after the other, little endian as this processor's. */
class Bytes {
 public:
  explicit Bytes(const std::string& path) : path_(path), bytes_(readFile(path)) {}

  template <typename Number>
  Number next() {
    need(sizeof(Number));
    Number number;
    std::memcpy(&number, bytes_.data() + at_, sizeof(Number));
    at_ += sizeof(Number);
    return number;
  }

  std::string nextName() {
    const std::size_t end = bytes_.find('\0', at_);
    if (end == std::string::npos) need(bytes_.size());
    std::string name = bytes_.substr(at_, end - at_);
    at_ = end + 1;
    return name;
  }

  void skip(std::uint64_t count, std::uint64_t size) {
    if (count > bytes_.size() / size) need(bytes_.size());
    need(count * size);
    at_ += count * size;
  }

  void needEnd() const {
    if (at_ != bytes_.size())
      throw InputError(path_ + ": has " + std::to_string(bytes_.size() - at_) + " bytes behind its last entry");
  }

 private:
  void need(std::uint64_t n) const {
    if (n > bytes_.size() - at_) throw InputError(path_ + ": is cut short");
  }

  std::string path_, bytes_;
  std::size_t at_{0};
};

/** \brief Throws unless the rotation is one. \param q w x y z */
Eigen::Isometry3d poseOf(const std::string& owner, const double (&q)[4], const double (&t)[3]) {
  Eigen::Quaterniond rotation(q[0], q[1], q[2], q[3]);
  const Eigen::Vector3d translation(t[0], t[1], t[2]);
  if (!translation.allFinite() || !(std::abs(rotation.norm() - 1) < 1e-2))
    throw InputError(owner + ": its pose is none, must be a quaternion of length 1 and three finite numbers");
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = rotation.normalized().toRotationMatrix();
  T.translation() = translation;
  return T;
}

Cameras readCamerasBinary(const std::string& path) {
  Bytes bytes(path);
  Cameras cameras;
  for (auto n = bytes.next<std::uint64_t>(); n > 0; --n) {
    const auto id = bytes.next<std::uint32_t>();
    const ColmapModel model = colmapModel(path, bytes.next<std::int32_t>());
    const auto width = static_cast<double>(bytes.next<std::uint64_t>());
    const auto height = static_cast<double>(bytes.next<std::uint64_t>());
    std::vector<double> parameters(model.parameters);
    for (double& p : parameters) p = bytes.next<double>();
    cameras[id] = colmapIntrinsics(path, model.name, width, height, parameters);
  }
  bytes.needEnd();
  return cameras;
}

std::vector<Registered> readImagesBinary(const std::string& path) {
  Bytes bytes(path);
  std::vector<Registered> images;
  for (auto n = bytes.next<std::uint64_t>(); n > 0; --n) {
    (void)bytes.next<std::uint32_t>();
    double q[4], t[3];
    for (double& x : q) x = bytes.next<double>();
    for (double& x : t) x = bytes.next<double>();
    Registered image;
    image.camera = bytes.next<std::uint32_t>();
    image.name = bytes.nextName();
    image.T_camera_world = poseOf(path + ": image " + image.name, q, t);
    bytes.skip(bytes.next<std::uint64_t>(), 2 * sizeof(double) + sizeof(std::uint64_t));  // its points
    images.push_back(std::move(image));
  }
  bytes.needEnd();
  return images;
}

/** \brief The lines of a text file, without comments; empty ones too. */
std::vector<std::string> linesOf(const std::string& path) {
  std::vector<std::string> lines;
  std::istringstream text(readText(path));
  for (std::string line; std::getline(text, line);)
    if (line.empty() || line[0] != '#') lines.push_back(line);
  return lines;
}

bool isBlank(const std::string& line) { return line.find_first_not_of(" \t\r") == std::string::npos; }

Cameras readCamerasText(const std::string& path) {
  Cameras cameras;
  for (const std::string& line : linesOf(path)) {
    if (isBlank(line)) continue;
    std::istringstream words(line);
    std::uint32_t id = 0;
    std::string model;
    double width = 0, height = 0;
    if (!(words >> id >> model >> width >> height))
      throw InputError(path + ": a line is no camera, must be number, model, width, height, parameters");
    std::vector<double> parameters;
    for (double p; words >> p;) parameters.push_back(p);
    cameras[id] = colmapIntrinsics(path, model, width, height, parameters);
  }
  return cameras;
}

/** \brief Whether a line is triples of numbers, or blank. */
bool isPoints(const std::string& line) {
  std::istringstream words(line);
  std::size_t numbers = 0;
  for (double number; words >> number;) ++numbers;
  return words.eof() && numbers % 3 == 0;
}

/** \brief Two lines an image, the second for its points, which may be empty. */
std::vector<Registered> readImagesText(const std::string& path) {
  std::vector<Registered> images;
  const std::vector<std::string> lines = linesOf(path);
  for (std::size_t k = 0; k < lines.size(); k += 2) {
    if (isBlank(lines[k]) && k + 1 >= lines.size()) break;
    std::istringstream words(lines[k]);
    std::uint32_t id = 0;
    double q[4], t[3];
    Registered image;
    if (!(words >> id >> q[0] >> q[1] >> q[2] >> q[3] >> t[0] >> t[1] >> t[2] >> image.camera >> std::ws) ||
        !std::getline(words, image.name) || isBlank(image.name))
      throw InputError(path + ": line " + std::to_string(k + 1) +
                       " beside comments is no image, must be number, quaternion, translation, camera, name, and a "
                       "line of points behind it, which may be empty");
    while (std::isspace(static_cast<unsigned char>(image.name.back()))) image.name.pop_back();
    if (k + 1 < lines.size() && !isPoints(lines[k + 1]))
      throw InputError(path + ": the line behind image " + image.name +
                       " is not its points, x y and a number each; where it has none, an empty line must be there");
    image.T_camera_world = poseOf(path + ": image " + image.name, q, t);
    images.push_back(std::move(image));
  }
  return images;
}

/** \brief Where the model is: sparse, or sparse/0; empty: nowhere. */
std::string modelFolder(const std::string& folder) {
  for (const char* name : {"sparse", "sparse/0"}) {
    const fs::path model = fs::path(folder) / name;
    if (isThere((model / "images.bin").string()) || isThere((model / "images.txt").string())) return model.string();
  }
  return "";
}

/** \brief COLMAP's two kinds: the one that was checked for geometric consistency first. */
std::string depthMapOf(const std::string& folder, const std::string& image) {
  for (const char* kind : {"geometric", "photometric"}) {
    const std::string path = (fs::path(folder) / "stereo" / "depth_maps" / (image + "." + kind + ".bin")).string();
    if (isThere(path)) return path;
  }
  return "";
}

}  // namespace

bool isColmapFolder(const std::string& folder) {
  std::error_code error;
  return fs::is_directory(fs::path(folder) / "images", error) && !modelFolder(folder).empty();
}

std::unique_ptr<Recording> openColmap(const std::string& folder, const RecordingOptions& options) {
  Photos photos;
  photos.kind = "colmap";
  photos.path = folder;
  const fs::path model = modelFolder(folder);
  const bool binary = isThere((model / "images.bin").string());
  const std::string cameras_path = (model / (binary ? "cameras.bin" : "cameras.txt")).string();
  const std::string images_path = (model / (binary ? "images.bin" : "images.txt")).string();
  const Cameras cameras = binary ? readCamerasBinary(cameras_path) : readCamerasText(cameras_path);
  const std::vector<Registered> images = binary ? readImagesBinary(images_path) : readImagesText(images_path);
  for (const char* used : {"sparse", "images", "stereo"}) photos.inputs.push_back((fs::path(folder) / used).string());
  photos.color_folder = (fs::path(folder) / "images").string();
  std::map<std::string, const Registered*> by_name;
  for (const Registered& image : images)
    if (!by_name.emplace(image.name, &image).second) throw InputError(images_path + ": names " + image.name + " twice");
  std::size_t photometric = 0, with_depth = 0;
  for (const auto& [name, image] : by_name) {
    Photo photo;
    photo.files.depth = depthMapOf(folder, name);
    photo.files.depth_was_there = !photo.files.depth.empty();
    const auto camera = cameras.find(image->camera);
    if (camera == cameras.end())
      throw InputError(images_path + ": image " + name + " is of camera " + std::to_string(image->camera) + ", which " +
                       cameras_path + " does not have");
    if (photo.files.depth_was_there && !isIdeal(camera->second.distortion))
      throw InputError(cameras_path + ": camera " + std::to_string(image->camera) +
                       " has a lens with distortion; depth maps are of images that colmap image_undistorter has "
                       "undistorted: its output folder must be given");
    if (photo.files.depth_was_there) ++with_depth;
    if (photo.files.depth.find(".photometric.bin") != std::string::npos) ++photometric;
    if (const std::string color = (fs::path(folder) / "images" / name).string(); isThere(color))
      photo.files.color = color;
    photo.camera.name = name;
    photo.camera.intrinsics = camera->second;
    photo.camera.T_world_camera = image->T_camera_world.inverse();
    photos.photos.push_back(std::move(photo));
  }
  const std::string maps = (fs::path(folder) / "stereo" / "depth_maps").string();
  if (!haveDepth(photos.photos) && !filesIn(maps).empty())  // an empty folder is what image_undistorter leaves
    throw InputError(maps + ": has no depth map of the images in " + images_path +
                     ", must have one named such as IMAGE.geometric.bin");
  if (photometric > 0)
    photos.warnings.push_back(folder + ": " + std::to_string(photometric) + " of " + std::to_string(with_depth) +
                              " depth maps are photometric, there is no geometric one; COLMAP has not compared them "
                              "with other views");
  return openPhotos(std::move(photos), options);
}

}  // namespace fuse_flow::io
