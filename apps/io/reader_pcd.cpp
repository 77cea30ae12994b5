#include "io/calibration.h"
#include "io/cloud_io.h"
#include "io/range.h"
#include "io/readers.h"

#include <pcl/common/io.h>
#include <pcl/point_types.h>

#include <cmath>
#include <filesystem>

namespace fuse_flow::io {
namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZRGB>;

/** \brief Least squares of pixel = f · ray + c over an image, rays being x/z or y/z. Points in their camera's frame
 *  determine the camera so; the general projection matrix that pcl::estimateProjectionMatrix seeks is not determined by
 *  a flat scene. */
class PinholeFit {
 public:
  void add(double ray, double pixel) {
    n_ += 1;
    r_ += ray;
    p_ += pixel;
    rr_ += ray * ray;
    rp_ += ray * pixel;
    pp_ += pixel * pixel;
  }
  double count() const { return n_; }
  double focal() const { return (n_ * rp_ - r_ * p_) / (n_ * rr_ - r_ * r_); }
  double centre() const { return (p_ - focal() * r_) / n_; }
  /** \brief Root mean square error, pixels. */
  double residual() const {
    const double f = focal(), c = centre();
    return std::sqrt(std::abs(pp_ + f * f * rr_ + n_ * c * c - 2 * f * rp_ - 2 * c * p_ + 2 * f * c * r_) / n_);
  }

 private:
  double n_{0}, r_{0}, p_{0}, rr_{0}, rp_{0}, pp_{0};
};

Intrinsics fitIntrinsics(const std::string& path, const Cloud& cloud) {
  PinholeFit horizontal, vertical;
  for (std::uint32_t v = 0; v < cloud.height; ++v)
    for (std::uint32_t u = 0; u < cloud.width; ++u) {
      const auto& p = cloud.at(static_cast<int>(u), static_cast<int>(v));
      if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z) || p.z <= 0) continue;
      horizontal.add(p.x / static_cast<double>(p.z), u);
      vertical.add(p.y / static_cast<double>(p.z), v);
    }
  if (horizontal.count() < 100)
    throw InputError(path + ": has " + std::to_string(static_cast<long>(horizontal.count())) +
                     " valid points, must be 100 or more to find the camera");
  constexpr double max_residual = 1.0;  // pixels
  if (!(horizontal.residual() < max_residual && vertical.residual() < max_residual && horizontal.focal() > 0 &&
        vertical.focal() > 0))
    throw InputError(
        path + ": its points are not those of a pinhole camera at their origin, looking along +z; the cloud must " +
        "be as the sensor delivered it, with the pose in VIEWPOINT");
  Intrinsics K;
  K.width = static_cast<int>(cloud.width);
  K.height = static_cast<int>(cloud.height);
  K.fx = static_cast<float>(horizontal.focal());
  K.fy = static_cast<float>(vertical.focal());
  K.cx = static_cast<float>(horizontal.centre());
  K.cy = static_cast<float>(vertical.centre());
  return K;
}

Camera cameraOf(const std::string& path, const Cloud& cloud, const SensorPose& pose) {
  Camera camera;
  camera.name = std::filesystem::path(path).stem().string();
  camera.intrinsics = fitIntrinsics(path, cloud);
  camera.T_world_camera.linear() = pose.orientation.cast<double>().normalized().toRotationMatrix();
  camera.T_world_camera.translation() = pose.origin.head<3>().cast<double>();
  return camera;
}

class PcdRecording : public Recording {
 public:
  void add(const std::string& path, bool read_color) {
    pcl::PCLPointCloud2 blob;
    Cloud cloud;
    const SensorPose pose = readCloud(path, blob);
    if (blob.height < 2 || blob.width < 2)
      throw InputError(path + ": is an unorganised cloud (" + std::to_string(blob.width) + "x" +
                       std::to_string(blob.height) + "), must be organised: a point for each pixel, in rows");
    {
      const SilencePcl silence;  // about the colour that the file may lack
      pcl::fromPCLPointCloud2(blob, cloud);
    }
    cameras_.push_back(cameraOf(path, cloud, pose));
    checkCameraInput(path, cameras_.back());
    const bool has_color =
        read_color && (pcl::getFieldIndex(blob, "rgb") >= 0 || pcl::getFieldIndex(blob, "rgba") >= 0);

    LoadedView& images = images_.emplace_back();
    images.depth32.resize(static_cast<int>(cloud.width), static_cast<int>(cloud.height));
    if (has_color) images.color.resize(images.depth32.width, images.depth32.height);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const bool finite = std::isfinite(cloud[i].x) && std::isfinite(cloud[i].y);  // else the pixel has no point
      images.depth32.data[i] = finite ? cloud[i].z : std::nanf("");
      if (has_color) images.color.data[i] = {cloud[i].r, cloud[i].g, cloud[i].b};
    }
  }

  std::string kind() const override { return "pcd"; }
  std::size_t frameCount() const override { return 1; }
  const std::vector<Camera>& cameras() const override { return cameras_; }

  void read(std::size_t, LoadedFrame& out) override {
    out.images = images_;
    out.rig.cameras = cameras_;
    out.rig.stamp = 0;
    out.rig.views.assign(cameras_.size(), DepthView());
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      out.rig.views[i].depth32 = out.images[i].depth32.view();
      out.rig.views[i].color = out.images[i].color.view();
    }
  }

 private:
  std::vector<Camera> cameras_;
  std::vector<LoadedView> images_;
};

}  // namespace

bool isPcdFile(const std::string& path) {
  const std::string extension = std::filesystem::path(path).extension().string();
  return extension == ".pcd" || extension == ".PCD";
}

std::unique_ptr<Recording> openPcd(const std::vector<std::string>& paths, const RecordingOptions& options) {
  if (options.slide != 0) throw OptionError("--slide: " + paths[0] + ": PCD files are one instant, must be 0");
  if (options.depth_scale)
    throw OptionError("--depth-scale: " + paths[0] + ": points of PCD files are in metres, must not be given");
  std::vector<std::string> chosen = paths;
  if (!options.views.empty()) {
    chosen.clear();
    for (const std::size_t i : parseRange(options.views, paths.size(), "--views")) chosen.push_back(paths[i]);
  }
  auto recording = std::make_unique<PcdRecording>();
  for (const std::string& path : chosen) recording->add(path, options.read_color);
  return recording;
}

}  // namespace fuse_flow::io
