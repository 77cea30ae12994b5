#pragma once

/** \file
 *  \brief Rigs whose cameras do not stand where they are thought to stand. */

#include "scenes.h"

#include <string>
#include <vector>

namespace scenes {

constexpr double kDegree = 0.017453292519943295;

/** \brief A floor, two walls and a ball: surfaces in all directions, within 3 m of the origin. */
inline Surface cornerAndBall() {
  return nearest({plane({0, -1, 0}, -0.5), plane({-0.8, 0, -0.6}, -1.5), plane({0.6, 0, -0.8}, -1.6),
                  sphere({0.1, 0.15, 1.2}, 0.2)});
}

/** \brief Cameras in a row that see it, of 160 × 120 pixels. */
inline std::vector<fuse_flow::Camera> cornerCameras(int n) { return cameraRow(n, 160, 120, 150); }

/** \brief A pose moved by metres along a direction, and turned by degrees about an axis through the camera. */
inline Eigen::Isometry3d moved(const Eigen::Isometry3d& T, const Vector3d& by, double degrees = 0,
                               const Vector3d& axis = Vector3d::UnitY()) {
  Eigen::Isometry3d result = T;
  result.pretranslate(by);
  result.rotate(Eigen::AngleAxisd(degrees * kDegree, axis.normalized()));
  return result;
}

/** \brief How far a camera's centre is from where another pose has it, metres. */
inline double apart(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return (a.translation() - b.translation()).norm();
}
/** \brief Between two orientations, degrees. */
inline double turned(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return Eigen::AngleAxisd(Eigen::Matrix3d(a.linear().transpose() * b.linear())).angle() / kDegree;
}

inline std::vector<Eigen::Isometry3d> poses(const std::vector<fuse_flow::Camera>& cameras) {
  std::vector<Eigen::Isometry3d> result;
  for (const fuse_flow::Camera& camera : cameras) result.push_back(camera.T_world_camera);
  return result;
}

/** \brief Grey levels that change over the world as given. */
template <typename Grey>
void paintWorld(Scene& scene, const Grey& grey) {
  scene.color.resize(scene.depth.size());
  for (std::size_t i = 0; i < scene.depth.size(); ++i) {
    const fuse_flow::Intrinsics& K = scene.rig.cameras[i].intrinsics;
    scene.color[i].resize(K.width, K.height);
    for (int v = 0; v < K.height; ++v)
      for (int u = 0; u < K.width; ++u) {
        const fuse_flow::Vec3 p = fuse_flow::pointOnRay(
            fuse_flow::unproject(K, {static_cast<float>(u), static_cast<float>(v)}), scene.depth[i].at(u, v));
        const Vector3d x = scene.rig.cameras[i].T_world_camera * Vector3d(p.x, p.y, p.z);
        const auto level = static_cast<std::uint8_t>(grey(x));
        scene.color[i].at(u, v) = {level, level, level};
      }
  }
  scene.attach();
}

}  // namespace scenes
