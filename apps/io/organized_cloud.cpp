#include "io/organized_cloud.h"

#include <fuse_flow/depth_backprojection.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <vector>

// Compiled in method.cpp.
extern template class fuse_flow::DepthBackprojection<pcl::PointXYZRGB>;

namespace fuse_flow::io {
namespace {

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

Intrinsics fitIntrinsics(const std::string& path, const OrganizedCloud& cloud) {
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

/** \brief Throws InputError for a VIEWPOINT that is no pose: PCL takes words that are no numbers for whatever was in memory. */
void checkViewpoint(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  for (std::string line; std::getline(file, line) && line.rfind("DATA", 0) != 0;) {
    if (line.rfind("VIEWPOINT", 0) != 0) continue;
    std::istringstream words(line.substr(9));
    std::vector<float> numbers;
    bool all_numbers = true;
    for (std::string word; words >> word;) {
      char* end = nullptr;
      numbers.push_back(std::strtof(word.c_str(), &end));
      all_numbers = all_numbers && *end == '\0' && std::isfinite(numbers.back());
    }
    const auto is_zero = [](float number) { return number == 0; };
    if (!all_numbers || numbers.size() != 7 || std::all_of(numbers.begin() + 3, numbers.end(), is_zero))
      throw InputError(path + ": VIEWPOINT must be the camera's x y z and its quaternion qw qx qy qz, seven numbers");
  }
}

}  // namespace

void toOrganizedCloud(const Camera& camera, const DepthView& view, OrganizedCloud& cloud) {
  Camera at_origin = camera;
  at_origin.T_world_camera.setIdentity();
  DepthBackprojection<OrganizedCloud::PointType> backprojection;
  backprojection.setCamera(at_origin);
  backprojection.setView(view);
  backprojection.filter(cloud);
}

Camera cameraOf(const std::string& path, const OrganizedCloud& cloud) {
  if (cloud.height < 2 || cloud.width < 2)
    throw InputError(path + ": is an unorganised cloud (" + std::to_string(cloud.width) + "x" +
                     std::to_string(cloud.height) + "), must be organised: a point for each pixel, in rows");
  Camera camera;
  camera.name = std::filesystem::path(path).stem().string();
  camera.intrinsics = fitIntrinsics(path, cloud);
  checkViewpoint(path);
  camera.T_world_camera.linear() = cloud.sensor_orientation_.cast<double>().normalized().toRotationMatrix();
  camera.T_world_camera.translation() = cloud.sensor_origin_.head<3>().cast<double>();
  return camera;
}

void imagesOf(const OrganizedCloud& cloud, bool has_color, LoadedView& images) {
  images = {};
  images.depth32.resize(static_cast<int>(cloud.width), static_cast<int>(cloud.height));
  if (has_color) images.color.resize(images.depth32.width, images.depth32.height);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const bool finite = std::isfinite(cloud[i].x) && std::isfinite(cloud[i].y);  // else the pixel has no point
    images.depth32.data[i] = finite ? cloud[i].z : std::nanf("");
    if (has_color) images.color.data[i] = {cloud[i].r, cloud[i].g, cloud[i].b};
  }
}

}  // namespace fuse_flow::io
