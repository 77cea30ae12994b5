#include "recordings/readers/photo_recording.h"

#include "recordings/calibrations/calibration.h"
#include "recordings/images/float_image.h"
#include "recordings/range.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace fuse_flow::io {
namespace {

/** \brief The intrinsics of the same photograph in another size. \param middle of the first pixel, to which coordinates count from the point that
 *  stays: 0, or 0.5 where that is its corner */
Intrinsics resized(Intrinsics K, int width, int height, float middle) {
  const float x = static_cast<float>(width) / static_cast<float>(K.width);
  const float y = static_cast<float>(height) / static_cast<float>(K.height);
  K.fx *= x;
  K.fy *= y;
  K.cx = (K.cx + middle) * x - middle;
  K.cy = (K.cy + middle) * y - middle;
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
float aside(const Intrinsics& K, const ImageSize& size) {
  return std::abs(K.cx / static_cast<float>(size.width) - 0.5f) +
         std::abs(K.cy / static_cast<float>(size.height) - 0.5f);
}

class PhotoRecording : public Recording {
 public:
  PhotoRecording(Photos photos, const RecordingOptions& options)
      : photos_(std::move(photos)),
        have_depth_(haveDepth(photos_.photos)),
        unit_(options.depth_scale.value_or(1.0f)),
        loading_(options) {
    warnings_ = photos_.warnings;
    readSizes();
    settleSizes();
    for (std::size_t i = 0; i < photos_.photos.size(); ++i) cameras_.push_back(cameraOf(i));
    if (!options.read_color)
      for (Photo& photo : photos_.photos) photo.files.color.clear();
  }

  std::string kind() const override { return photos_.kind; }
  std::size_t frameCount() const override { return 1; }
  const std::vector<Camera>& cameras() const override { return cameras_; }
  bool hasDepth(std::size_t) const override { return have_depth_; }
  bool hasColor(std::size_t camera) const override { return !photos_.photos[camera].files.color.empty(); }
  std::vector<std::string> inputs() const override { return photos_.inputs; }

  void read(std::size_t, LoadedFrame& out) override {
    out.rig.cameras = cameras_;
    out.rig.views.resize(cameras_.size());
    out.rig.stamp = 0;
    out.images.resize(cameras_.size());
    out.damaged.clear();
    out.ended.clear();
    const auto load = [&](std::size_t i) {
      loadView(photos_.photos[i].files, cameras_[i], std::nullopt, out.images[i], out.rig.views[i]);
      if (!out.rig.views[i].missing())
        for (float& z : out.images[i].depth32.data) z *= unit_;
    };
    loading_.load(cameras_.size(), load, out);
  }

 private:
  /** \brief Of depth and photographs, whether colour is wanted or not: the intrinsics depend on it. Depth that is not there would have the size of
   *  its photograph. */
  void readSizes() {
    for (const Photo& photo : photos_.photos) {
      color_sizes_.push_back(photo.files.color.empty() ? ImageSize() : colorSize(photo.files.color));
      depth_sizes_.push_back(have_depth_ ? floatImageSize(photo.files.depth) : color_sizes_.back());
    }
  }

  bool otherSize(std::size_t i) const {
    return color_sizes_[i].width > 0 &&
           (color_sizes_[i].width != depth_sizes_[i].width || color_sizes_[i].height != depth_sizes_[i].height);
  }

  /** \brief Whose intrinsics they are, where the format does not say: of all depth maps, or of all photographs. */
  void settleSizes() {
    float of_depth = 0, of_photo = 0;
    bool unknown = false, differ = false;
    for (std::size_t i = 0; i < photos_.photos.size(); ++i) {
      const Intrinsics& K = photos_.photos[i].camera.intrinsics;
      if (K.width > 0) continue;
      unknown = true;
      if (!otherSize(i)) continue;
      differ = true;
      of_depth += aside(K, depth_sizes_[i]);
      of_photo += aside(K, color_sizes_[i]);
    }
    if (!unknown) return;
    const bool photographs = differ && of_photo < of_depth;
    if (differ)
      warnings_.push_back(photos_.path +
                          ": its camera files do not say of which size they are; by their principal "
                          "points they are taken for those of the " +
                          (photographs ? "images" : "depth maps"));
    for (std::size_t i = 0; i < photos_.photos.size(); ++i) {
      Intrinsics& K = photos_.photos[i].camera.intrinsics;
      if (K.width > 0) continue;
      if (photographs && color_sizes_[i].width == 0)
        throw InputError(photos_.path + ": camera '" + photos_.photos[i].camera.name +
                         "' is of a photograph that is not there, whose size must be known");
      const ImageSize size = photographs ? color_sizes_[i] : depth_sizes_[i];
      K.width = size.width;
      K.height = size.height;
      if (aside(K, size) > 0.5f)
        throw InputError(photos_.path + ": the principal point of camera '" + photos_.photos[i].camera.name +
                         "' lies far from the middle of its image of " + std::to_string(size.width) + "x" +
                         std::to_string(size.height) +
                         "; is it of an image of another size, or a share of the sides instead of pixels?");
    }
  }

  /** \brief In the size of its depth map. */
  Camera cameraOf(std::size_t i) const {
    const Photo& photo = photos_.photos[i];
    Camera camera = photo.camera;
    const Intrinsics K = camera.intrinsics;
    const ImageSize depth = depth_sizes_[i], color = color_sizes_[i];
    const float middle = photos_.scaled_from_first_middle ? 0.0f : 0.5f;
    if (have_depth_) checkSameShape(photo.files.depth, depth.width, depth.height, K);
    camera.intrinsics = resized(K, depth.width, depth.height, middle);
    if (color.width > 0) checkSameShape(photo.files.color, color.width, color.height, K);
    if (otherSize(i)) {
      camera.color.emplace();
      camera.color->intrinsics = resized(K, color.width, color.height, middle);
    }
    camera.T_world_camera.translation() *= static_cast<double>(unit_);
    camera.depth_scale = unit_;
    checkCameraInput(photos_.path, camera);
    return camera;
  }

  Photos photos_;
  bool have_depth_;
  float unit_;
  ViewLoading loading_;
  std::vector<ImageSize> depth_sizes_, color_sizes_;  ///< 0: there is no photograph
  std::vector<Camera> cameras_;
};

/** \brief A line where a folder of images is there, but not an image for each photograph. */
void warnOfMissing(Photos& photos, const std::string& folder, const char* what, std::string ViewFiles::*file) {
  const auto missing = std::count_if(photos.photos.begin(), photos.photos.end(),
                                     [&](const Photo& photo) { return (photo.files.*file).empty(); });
  if (folder.empty() || missing == 0) return;
  photos.warnings.push_back(folder + ": " + std::to_string(missing) + " of " + std::to_string(photos.photos.size()) +
                            " views have no " + what + " there under their name");
}

void refuse(const std::string& path, const RecordingOptions& options) {
  if (options.slide != 0) throw OptionError("--slide: " + path + ": its photographs are one instant, must be 0");
  if (!options.intrinsics.empty())
    throw OptionError("--intrinsics: " + path + ": its files tell them, must not be given");
}

/** \brief Cameras are named as their photographs are, which may lie in folders; each name is one of a folder, and there once. */
void makeNamesSafe(std::vector<Photo>& photos) {
  std::set<std::string> names;
  for (Photo& photo : photos) {
    std::string& name = photo.camera.name;
    std::replace_if(
        name.begin(), name.end(), [](char c) { return c == '/' || c == '\\'; }, '_');
    if (name == "." || name == "..") name = "_";
    const std::string first = name;
    for (int k = 2; !names.insert(name).second; ++k) name = first + "_" + std::to_string(k);
  }
}

/** \brief Of photographs with and without depth, those with depth; of photographs without depth, those that are there. */
void choose(Photos& photos) {
  std::vector<Photo>& all = photos.photos;
  const std::size_t count = all.size();
  const bool have_depth = haveDepth(all);
  const auto without = [&](const Photo& photo) { return (have_depth ? photo.files.depth : photo.files.color).empty(); };
  all.erase(std::remove_if(all.begin(), all.end(), without), all.end());
  if (all.empty())
    throw InputError(photos.path + ": has neither depth maps nor photographs under the names of its cameras");
  const std::string left_out = std::to_string(count - all.size()) + " of " + std::to_string(count) + " images ";
  if (have_depth) {
    if (all.size() < count)
      photos.warnings.push_back(photos.path + ": " + left_out + "have no depth map and are left out");
    return;
  }
  for (Photo& photo : all) photo.files.color_alone = true;
  photos.warnings.push_back(photos.path + ": has no depth maps; its " + std::to_string(all.size()) +
                            " images are photographs without depth");
  if (all.size() < count) photos.warnings.push_back(photos.path + ": " + left_out + "are not there and are left out");
}

}  // namespace

bool haveDepth(const std::vector<Photo>& photos) {
  return std::any_of(photos.begin(), photos.end(), [](const Photo& photo) { return !photo.files.depth.empty(); });
}

std::unique_ptr<Recording> openPhotos(Photos photos, const RecordingOptions& options) {
  refuse(photos.path, options);
  choose(photos);
  if (!options.views.empty()) {
    std::vector<Photo> chosen;
    for (const std::size_t i : parseRange(options.views, photos.photos.size(), "--views"))
      chosen.push_back(photos.photos[i]);
    photos.photos = std::move(chosen);
  }
  if (haveDepth(photos.photos)) {
    if (options.read_color) warnOfMissing(photos, photos.color_folder, "photograph", &ViewFiles::color);
    warnOfMissing(photos, photos.confidence_folder, "confidence", &ViewFiles::confidence);
  }
  makeNamesSafe(photos.photos);
  if (!options.depth_scale)
    photos.warnings.push_back(photos.path +
                              ": its unit of length is taken for the metre; if it is another, --depth-scale gives "
                              "metres for one unit, of depth and of positions alike");
  return std::make_unique<PhotoRecording>(std::move(photos), options);
}

}  // namespace fuse_flow::io
