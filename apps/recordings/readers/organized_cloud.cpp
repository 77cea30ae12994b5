#include <fuse_flow/recordings/organized_cloud.h>

#include "recordings/calibrations/lens_fit.h"

#include <fuse_flow/filters/depth_backprojection.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <vector>

// Compiled in instances.cpp.
extern template class fuse_flow::DepthBackprojection<pcl::PointXYZRGB>;

namespace fuse_flow::io {
namespace {

/** \brief Of each pixel that has a point. */
std::vector<PixelRay> raysOf(const OrganizedCloud& cloud) {
  std::vector<PixelRay> rays;
  for (std::uint32_t v = 0; v < cloud.height; ++v)
    for (std::uint32_t u = 0; u < cloud.width; ++u) {
      const auto& p = cloud.at(static_cast<int>(u), static_cast<int>(v));
      if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z) || p.z <= 0) continue;
      rays.push_back({static_cast<double>(u), static_cast<double>(v), p.x / static_cast<double>(p.z),
                      p.y / static_cast<double>(p.z)});
    }
  return rays;
}

/** \brief Some thousand, evenly spread, of as many as there are. */
std::vector<PixelRay> someOf(const std::vector<PixelRay>& rays) {
  constexpr std::size_t most = 4000;
  if (rays.size() <= most) return rays;
  std::vector<PixelRay> some;
  for (std::size_t k = 0; k < most; ++k) some.push_back(rays[k * rays.size() / most]);
  return some;
}

Intrinsics fitIntrinsics(const std::string& path, const OrganizedCloud& cloud, std::vector<std::string>* warnings) {
  const std::vector<PixelRay> rays = raysOf(cloud);
  if (rays.size() < 100)
    throw InputError(path + ": has " + std::to_string(rays.size()) +
                     " valid points, must be 100 or more to find the camera");
  const LensFit of_some = fitLens(someOf(rays), static_cast<int>(cloud.width), static_cast<int>(cloud.height));
  const LensFit fit = measureLens(of_some.intrinsics, rays);
  constexpr double max_rms = 1.0, notable = 0.25;  // pixels
  const Intrinsics& K = fit.intrinsics;
  if (!(fit.rms < max_rms && K.fx > 0 && K.fy > 0))
    throw InputError(
        path +
        ": its points are not those of a camera at their origin, looking along +z, whose lens the Brown-Conrady " +
        "and rational models express; the cloud must be as the sensor delivered it, with the pose in VIEWPOINT");
  if (fit.worst > notable && warnings != nullptr) {
    std::ostringstream line;
    line << path << ": its points are moved to the rays of a lens that fits them to " << fit.rms
         << " pixels, at worst by " << fit.worst << " pixels, which is " << 1000 * fit.worst / static_cast<double>(K.fx)
         << " mm for each metre of distance";
    warnings->push_back(line.str());
  }
  return K;
}

/** \brief Throws InputError for a VIEWPOINT that is not a pose: where a word is not a number, PCL leaves the value uninitialised. */
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

Camera cameraOf(const std::string& path, const OrganizedCloud& cloud, std::vector<std::string>* warnings) {
  if (cloud.height < 2 || cloud.width < 2)
    throw InputError(path + ": is an unorganised cloud (" + std::to_string(cloud.width) + "x" +
                     std::to_string(cloud.height) + "), must be organised: a point for each pixel, in rows");
  Camera camera;
  camera.name = std::filesystem::path(path).stem().string();
  camera.intrinsics = fitIntrinsics(path, cloud, warnings);
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
