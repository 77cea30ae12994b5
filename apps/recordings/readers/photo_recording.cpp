#include "recordings/readers/photo_recording.h"

#include "recordings/calibration.h"
#include "recordings/files/float_image.h"
#include "recordings/range.h"

#include <algorithm>
#include <cmath>

namespace fuse_flow::io {
namespace {

/** \brief The intrinsics of the same photograph in another size. Pixel (0, 0) reaches from −0.5 to 0.5. */
Intrinsics resized(Intrinsics K, int width, int height) {
  const float x = static_cast<float>(width) / static_cast<float>(K.width);
  const float y = static_cast<float>(height) / static_cast<float>(K.height);
  K.fx *= x;
  K.fy *= y;
  K.cx = (K.cx + 0.5f) * x - 0.5f;
  K.cy = (K.cy + 0.5f) * y - 0.5f;
  K.width = width;
  K.height = height;
  return K;
}

/** \brief Throws unless an image shows what another shows, in another size: sides may be rounded. */
void checkSameShape(const std::string& path, int width, int height, const Intrinsics& K) {
  const double x = static_cast<double>(width) / K.width, y = static_cast<double>(height) / K.height;
  if (std::abs(x * K.height - height) <= 1.0 + x || std::abs(y * K.width - width) <= 1.0 + y) return;
  throw InputError(path + ": is " + std::to_string(width) + "x" + std::to_string(height) + " pixels, its camera " +
                   std::to_string(K.width) + "x" + std::to_string(K.height) + ", must be of the same shape");
}

/** \brief How far the principal point is from the middle of an image, of its sides. */
float aside(const Intrinsics& K, int width, int height) {
  return std::abs(K.cx / static_cast<float>(width) - 0.5f) + std::abs(K.cy / static_cast<float>(height) - 0.5f);
}

class PhotoRecording : public Recording {
 public:
  PhotoRecording(Photos photos, float unit) : photos_(std::move(photos)), unit_(unit) {
    warnings_ = photos_.warnings;
    for (Photo& photo : photos_.photos) cameras_.push_back(cameraOf(photo));
    if (!assumed_.empty())
      warnings_.push_back(
          photos_.path + ": its camera files do not say of which size they are; by their principal points " + assumed_);
  }

  std::string kind() const override { return photos_.kind; }
  std::size_t frameCount() const override { return 1; }
  const std::vector<Camera>& cameras() const override { return cameras_; }
  std::vector<std::string> inputs() const override { return photos_.inputs; }

  void read(std::size_t, LoadedFrame& out) override {
    out.rig.cameras = cameras_;
    out.rig.views.resize(cameras_.size());
    out.rig.stamp = 0;
    out.images.resize(cameras_.size());
    out.damaged.clear();
    out.ended.clear();
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      loadView(photos_.photos[i].files, std::nullopt, i, false, out);
      for (float& z : out.images[i].depth32.data) z *= unit_;
    }
  }

 private:
  /** \brief In the size of its depth map. */
  Camera cameraOf(const Photo& photo) {
    Camera camera = photo.camera;
    FloatImage depth;
    ColorImage color;
    readFloatImage(photo.files.depth, depth);
    if (!photo.files.color.empty()) readColor(photo.files.color, color);
    const bool other_size = !color.empty() && (color.width != depth.width || color.height != depth.height);
    Intrinsics K = camera.intrinsics;
    if (K.width == 0) {
      const bool of_depth = color.empty() || aside(K, depth.width, depth.height) <= aside(K, color.width, color.height);
      K.width = of_depth ? depth.width : color.width;
      K.height = of_depth ? depth.height : color.height;
      if (other_size) assumed_ = std::string("they are taken for those of the ") + (of_depth ? "depth maps" : "images");
    }
    checkSameShape(photo.files.depth, depth.width, depth.height, K);
    if (!color.empty()) checkSameShape(photo.files.color, color.width, color.height, K);
    camera.intrinsics = resized(K, depth.width, depth.height);
    if (other_size) {
      camera.color.emplace();
      camera.color->intrinsics = resized(K, color.width, color.height);
    }
    camera.T_world_camera.translation() *= static_cast<double>(unit_);
    camera.depth_scale = unit_;
    checkCameraInput(photos_.path, camera);
    return camera;
  }

  Photos photos_;
  float unit_;
  std::string assumed_;  ///< what was, about the size of intrinsics
  std::vector<Camera> cameras_;
};

void refuse(const std::string& path, const RecordingOptions& options) {
  if (options.slide != 0) throw OptionError("--slide: " + path + ": its photographs are one instant, must be 0");
  if (!options.intrinsics.empty())
    throw OptionError("--intrinsics: " + path + ": its files tell them, must not be given");
  if (options.pose_convention != PoseConvention::CameraToWorld)
    throw OptionError("--pose-convention: " + path + ": the convention of its poses is known, must not be given");
}

}  // namespace

std::unique_ptr<Recording> openPhotos(Photos photos, const RecordingOptions& options) {
  refuse(photos.path, options);
  if (photos.photos.empty()) throw InputError(photos.path + ": has no depth maps; depth is not estimated here");
  if (photos.without_depth > 0)
    photos.warnings.push_back(photos.path + ": " + std::to_string(photos.without_depth) + " of " +
                              std::to_string(photos.without_depth + photos.photos.size()) +
                              " images have no depth map and are left out");
  if (!options.views.empty()) {
    std::vector<Photo> chosen;
    for (const std::size_t i : parseRange(options.views, photos.photos.size(), "--views"))
      chosen.push_back(photos.photos[i]);
    photos.photos = std::move(chosen);
  }
  if (!options.read_color)
    for (Photo& photo : photos.photos) photo.files.color.clear();
  if (!options.depth_scale)
    photos.warnings.push_back(photos.path +
                              ": its unit of length is taken for the metre; if it is another, --depth-scale gives "
                              "metres for one unit, of depth and of positions alike");
  return std::make_unique<PhotoRecording>(std::move(photos), options.depth_scale.value_or(1.0f));
}

}  // namespace fuse_flow::io
