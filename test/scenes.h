#pragma once

/** \file
 *  \brief Scenes whose geometry is known by hand, rendered to depth by meeting rays with surfaces. */

#include "sanitized.h"
#include "surfaces.h"

#include <fuse_flow/fuse_flow.h>
#include <fuse_flow/point_types.h>
#include <fuse_flow/recordings/image.h>

#include <pcl/point_cloud.h>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace scenes {

/** \brief What takes long takes ten times as long under sanitizers, which look at the code and not at what it finds: there one of
 *  each kind is enough. */
#if defined(FUSE_FLOW_TEST_SANITIZED)
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

using Eigen::Vector3d;
using Cloud = pcl::PointCloud<fuse_flow::PointFused>;

/** \brief A camera at eye whose optical axis meets target; the world's y is down, as in a camera at rest. */
inline fuse_flow::Camera lookAt(const Vector3d& eye, const Vector3d& target, int width = 96, int height = 72,
                                float focal = 90) {
  fuse_flow::Camera camera;
  camera.name = "test camera";
  camera.intrinsics.width = width;
  camera.intrinsics.height = height;
  camera.intrinsics.fx = camera.intrinsics.fy = focal;
  camera.intrinsics.cx = 0.5f * static_cast<float>(width - 1);
  camera.intrinsics.cy = 0.5f * static_cast<float>(height - 1);
  const Vector3d forward = (target - eye).normalized();
  const Vector3d right = forward.cross(-Vector3d::UnitY()).normalized();
  camera.T_world_camera.linear() << right, forward.cross(right), forward;
  camera.T_world_camera.translation() = eye;
  return camera;
}

/** \brief Cameras side by side near z = 0 that look at (0, 0, 1.5), no two from the same place. */
inline std::vector<fuse_flow::Camera> cameraRow(int n, int width = 96, int height = 72, float focal = 90) {
  std::vector<fuse_flow::Camera> cameras;
  for (int i = 0; i < n; ++i) {
    const double x = 0.37 * (i - 0.5 * (n - 1)) + 0.013;
    cameras.push_back(lookAt({x, i % 2 ? 0.11 : -0.07, 0.02 * i}, {0, 0, 1.5}, width, height, focal));
    cameras.back().name = "test camera " + std::to_string(i);
  }
  return cameras;
}

/** \brief Cameras of one pose, at the origin, along z. */
inline std::vector<fuse_flow::Camera> sameCameras(int n, int width, int height, float focal) {
  return std::vector<fuse_flow::Camera>(static_cast<std::size_t>(n),
                                        lookAt({0, 0, 0}, {0, 0, 1}, width, height, focal));
}

inline fuse_flow::io::FloatImage render(const fuse_flow::Camera& camera, const Surface& surface) {
  const fuse_flow::Intrinsics& K = camera.intrinsics;
  fuse_flow::io::FloatImage depth;
  depth.resize(K.width, K.height);
  for (int v = 0; v < K.height; ++v)
    for (int u = 0; u < K.width; ++u) {
      const Vector3d ray((u - static_cast<double>(K.cx)) / static_cast<double>(K.fx),
                         (v - static_cast<double>(K.cy)) / static_cast<double>(K.fy),
                         1);  // length 1 along the axis: t is the depth
      depth.at(u, v) =
          static_cast<float>(surface(camera.T_world_camera.translation(), camera.T_world_camera.linear() * ray));
    }
  return depth;
}

inline fuse_flow::io::FloatImage uniform(int width, int height, float value) {
  fuse_flow::io::FloatImage image;
  image.resize(width, height);
  std::fill(image.data.begin(), image.data.end(), value);
  return image;
}

/** \brief A rig frame with the memory behind it. Change an image's pixels at will; what changes which images there are
 *  calls attach(). */
struct Scene {
  fuse_flow::RigFrame rig;
  std::vector<fuse_flow::io::FloatImage> depth;  ///< metres
  std::vector<fuse_flow::io::DepthImage> depth16;
  std::vector<fuse_flow::io::ColorImage> color;
  std::vector<fuse_flow::io::FloatImage> confidence;

  Scene() = default;
  Scene(Scene&&) = default;
  Scene& operator=(Scene&&) = default;
  Scene(const Scene&) = delete;  // the views of a copy would point into the original

  /** \brief Points the views at the images: float depth where there is no integer depth. */
  void attach() {
    rig.views.assign(depth.size(), {});
    for (std::size_t i = 0; i < depth.size(); ++i) {
      if (i < depth16.size() && !depth16[i].empty()) {
        rig.views[i].depth16 = depth16[i].view();
      } else {
        rig.views[i].depth32 = depth[i].view();
      }
      if (i < color.size()) rig.views[i].color = color[i].view();
      if (i < confidence.size()) rig.views[i].confidence = confidence[i].view();
    }
  }

  void paint(const fuse_flow::Rgb8& value) {
    color.resize(depth.size());
    for (std::size_t i = 0; i < depth.size(); ++i) {
      color[i].resize(depth[i].width, depth[i].height);
      std::fill(color[i].data.begin(), color[i].data.end(), value);
    }
    attach();
  }
};

inline Scene makeScene(const std::vector<fuse_flow::Camera>& cameras, const Surface& surface) {
  Scene scene;
  scene.rig.cameras = cameras;
  for (const fuse_flow::Camera& camera : cameras) scene.depth.push_back(render(camera, surface));
  scene.attach();
  return scene;
}

/** \brief A row of cameras in front of a wall 1.5 m away. */
inline Scene wall(int cameras) { return makeScene(cameraRow(cameras), plane({0, 0, 1}, 1.5)); }

/** \brief Cameras whose images are each of one depth. */
inline Scene makeFlatScene(const std::vector<fuse_flow::Camera>& cameras, const std::vector<float>& depths) {
  Scene scene;
  scene.rig.cameras = cameras;
  for (std::size_t i = 0; i < cameras.size(); ++i)
    scene.depth.push_back(uniform(cameras[i].intrinsics.width, cameras[i].intrinsics.height, depths[i]));
  scene.attach();
  return scene;
}

/** \brief Normal noise on every measurement, the same on every run. */
inline void addNoise(Scene& scene, float sigma, unsigned int seed = 7) {
  std::mt19937 random(seed);
  const auto draw = [&random] {  // the sum of four uniform numbers: the standard distributions differ between libraries
    float sum = 0;
    for (int k = 0; k < 4; ++k) sum += static_cast<float>(random() >> 8) * 0x1p-24f;
    return 1.7320508f * (sum - 2.0f);
  };
  for (fuse_flow::io::FloatImage& image : scene.depth)
    for (float& z : image.data)
      if (z > 0) z += sigma * draw();
}

/** \brief A slanted wall with a ball in front of it: depth edges, curvature, hidden places. */
inline Surface ballAndWall() {
  return nearest({plane(Vector3d(0.21, -0.13, 1).normalized(), 1.517), sphere({0.053, 0.021, 1.117}, 0.183)});
}

template <typename PointT = fuse_flow::PointFused>
pcl::PointCloud<PointT> fuse(const fuse_flow::RigFrame& frame, const fuse_flow::FuseFlowParameters& parameters = {},
                             unsigned int threads = 2, fuse_flow::FrameStatistics* statistics = nullptr) {
  fuse_flow::FuseFlow<PointT> fusion;
  fusion.setParameters(parameters);
  fusion.setNumberOfThreads(threads);
  pcl::PointCloud<PointT> cloud;
  fusion.fuse(frame, cloud);
  if (statistics) *statistics = fusion.getStatistics();
  return cloud;
}

/** \brief All of a point. */
using Bytes = std::array<char, sizeof(fuse_flow::PointFused)>;
inline std::vector<Bytes> bytes(const Cloud& cloud) {
  std::vector<Bytes> result(cloud.size());
  for (std::size_t k = 0; k < cloud.size(); ++k) std::memcpy(result[k].data(), &cloud[k], sizeof(Bytes));
  return result;
}

/** \brief How many points of a have no partner in b within tolerance. */
inline std::size_t withoutPartner(const Cloud& a, const Cloud& b, float tolerance) {
  std::vector<Eigen::Vector3f> sorted;
  for (const auto& point : b) sorted.push_back(point.getVector3fMap());
  const auto byX = [](const Eigen::Vector3f& p, const Eigen::Vector3f& q) { return p.x() < q.x(); };
  std::sort(sorted.begin(), sorted.end(), byX);
  std::size_t alone = 0;
  for (const auto& point : a) {
    const Eigen::Vector3f p = point.getVector3fMap();
    const auto begin = std::lower_bound(sorted.begin(), sorted.end(), p - Eigen::Vector3f::Constant(tolerance), byX);
    const auto end = std::upper_bound(sorted.begin(), sorted.end(), p + Eigen::Vector3f::Constant(tolerance), byX);
    alone += std::any_of(begin, end, [&](const auto& q) { return (p - q).norm() <= tolerance; }) ? 0 : 1;
  }
  return alone;
}

/** \brief The measurements of all cameras, back-projected in double precision. */
inline std::vector<Vector3d> backProjected(const Scene& scene) {
  std::vector<Vector3d> points;
  for (std::size_t i = 0; i < scene.depth.size(); ++i) {
    const fuse_flow::Camera& camera = scene.rig.cameras[i];
    for (int v = 0; v < camera.intrinsics.height; ++v)
      for (int u = 0; u < camera.intrinsics.width; ++u) {
        const auto z = static_cast<double>(scene.depth[i].at(u, v));
        const Vector3d ray((u - static_cast<double>(camera.intrinsics.cx)) / static_cast<double>(camera.intrinsics.fx),
                           (v - static_cast<double>(camera.intrinsics.cy)) / static_cast<double>(camera.intrinsics.fy),
                           1);
        if (z > 0) points.push_back(camera.T_world_camera * Vector3d(z * ray));
      }
  }
  return points;
}

}  // namespace scenes
