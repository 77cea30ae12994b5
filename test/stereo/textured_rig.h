#pragma once

/** \file
 *  \brief Cameras on an arc before surfaces with a texture, whose depth is known by hand: what multi-view stereo is tried on. */

#include "../surfaces.h"

#include <fuse_flow/stereo/multi_view_stereo.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

namespace textured {

using Eigen::Vector3d;

/** \brief Grey level of a point of a solid texture. */
using Texture = std::function<double(const Vector3d& p)>;

/** \brief Random levels at the corners of cubes of this size, metres, and between them what lies between; two sizes. */
inline Texture noise(double size) {
  const auto corner = [](std::int64_t x, std::int64_t y, std::int64_t z) {
    auto h = static_cast<std::uint32_t>(x * 73856093 ^ y * 19349663 ^ z * 83492791);
    h = (h ^ h >> 16) * 0x7feb352du;
    h = (h ^ h >> 15) * 0x846ca68bu;
    return (h ^ h >> 16) / 4294967296.0;
  };
  const auto at = [corner](const Vector3d& p) {
    const Vector3d floor = p.array().floor(), t = p - floor;
    double sum = 0;
    for (int k = 0; k < 8; ++k) {
      const Vector3d c(k & 1, k >> 1 & 1, k >> 2);
      double weight = 1;
      for (int axis = 0; axis < 3; ++axis) weight *= c[axis] > 0 ? t[axis] : 1 - t[axis];
      const Vector3d place = floor + c;
      sum += weight * corner(static_cast<std::int64_t>(place.x()), static_cast<std::int64_t>(place.y()),
                             static_cast<std::int64_t>(place.z()));
    }
    return sum;
  };
  return [=](const Vector3d& p) { return 30 + 120 * at(p / size) + 80 * at(p / (3 * size) + Vector3d(7, 3, 5)); };
}

/** \brief Cameras, their images, and the depth of what they see. */
struct Rig {
  fuse_flow::RigFrame frame;
  std::vector<std::vector<fuse_flow::Rgb8>> images;
  std::vector<std::vector<float>> depth;  ///< metres

  Rig() = default;
  Rig(Rig&&) = default;
  Rig& operator=(Rig&&) = default;
  Rig(const Rig&) = delete;  // its views would point into the original

  void render(const scenes::Surface& surface, const Texture& texture) {
    images.clear(), depth.clear(), frame.views.clear();
    for (const fuse_flow::Camera& camera : frame.cameras) {
      const fuse_flow::Camera own = fuse_flow::stereoCamera(camera);
      const fuse_flow::Intrinsics& K = own.intrinsics;
      images.emplace_back(), depth.emplace_back();
      for (int v = 0; v < K.height; ++v)
        for (int u = 0; u < K.width; ++u) {
          const fuse_flow::Ray ray = unproject(K, {static_cast<float>(u), static_cast<float>(v)});
          const Vector3d from = own.T_world_camera.translation();
          const Vector3d direction = own.T_world_camera.linear() * Vector3d(ray.x, ray.y, 1);
          const double z = surface(from, direction);
          const double level = z > 0 ? texture(from + z * direction) : 0;
          const auto grey = static_cast<std::uint8_t>(std::min(std::max(level, 0.0), 255.0));
          images.back().push_back({grey, grey, grey});
          depth.back().push_back(static_cast<float>(z));
        }
    }
    point();
  }

  /** \brief After a change of the images. */
  void point() {
    frame.views.resize(frame.cameras.size());
    for (std::size_t k = 0; k < images.size(); ++k) {
      const fuse_flow::Intrinsics K = fuse_flow::stereoCamera(frame.cameras[k]).intrinsics;
      frame.views[k].color = {images[k].data(), K.width, K.height};
    }
  }
};

/** \brief Cameras that look at (0, 0, 2) from 2 m, 8° apart, at two heights. Images of 4 : 3. */
inline Rig onArc(int cameras, int width = 128) {
  Rig rig;
  for (int k = 0; k < cameras; ++k) {
    fuse_flow::Camera camera;
    camera.name = "arc " + std::to_string(k);
    fuse_flow::Intrinsics& K = camera.intrinsics;
    K.width = width;
    K.height = width * 3 / 4;
    K.fx = K.fy = 0.9f * static_cast<float>(width);
    K.cx = 0.5f * static_cast<float>(K.width - 1);
    K.cy = 0.5f * static_cast<float>(K.height - 1);
    const double angle = (k - 0.5 * (cameras - 1)) * 8 * M_PI / 180;
    const Vector3d target(0, 0, 2);
    const Vector3d eye = target + 2.0 * Vector3d(std::sin(angle), k % 2 == 0 ? 0.0 : -0.15, -std::cos(angle));
    const Vector3d forward = (target - eye).normalized(), right = Vector3d::UnitY().cross(forward).normalized();
    camera.T_world_camera.linear() << right, forward.cross(right), forward;
    camera.T_world_camera.translation() = eye;
    rig.frame.cameras.push_back(camera);
  }
  return rig;
}

/** \brief How far depth is from what it should be. */
struct Errors {
  double found{0};   ///< share of the pixels with confidence over a half
  double median{0};  ///< of their errors, metres
  double bad{0};     ///< share of them that are off by more than 5 % of the depth
};

/** \brief Of all views that have depth; pixels within a window of the border are left out. */
inline Errors errorsOf(const Rig& rig, const fuse_flow::StereoFrame& found, float unit = 1) {
  std::vector<double> errors;
  double pixels = 0, bad = 0;
  for (std::size_t k = 0; k < found.views.size(); ++k) {
    const fuse_flow::Intrinsics& K = found.rig.cameras[k].intrinsics;
    for (int v = 4; v < K.height - 4; ++v)
      for (int u = 4; u < K.width - 4; ++u) {
        const auto place =
            static_cast<std::size_t>(v) * static_cast<std::size_t>(K.width) + static_cast<std::size_t>(u);
        const double truth = static_cast<double>(rig.depth[k][place] * unit);
        if (!(truth > 0)) continue;
        pixels += 1;
        if (found.views[k].confidence.empty() || !(found.views[k].confidence[place] > 0.5f)) continue;
        errors.push_back(std::abs(static_cast<double>(found.views[k].depth[place]) - truth));
        bad += errors.back() > 0.05 * truth ? 1 : 0;
      }
  }
  Errors result;
  if (errors.empty()) return result;
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
  std::nth_element(errors.begin(), middle, errors.end());
  result.found = static_cast<double>(errors.size()) / pixels;
  result.median = *middle;
  result.bad = bad / static_cast<double>(errors.size());
  return result;
}

/** \brief A wall 2.4 m away and a ball before it. */
inline scenes::Surface wallAndBall() {
  return scenes::nearest({scenes::plane(Vector3d(0.2, 0.1, 1), 2.4), scenes::sphere(Vector3d(0.1, -0.05, 1.9), 0.35)});
}

}  // namespace textured
