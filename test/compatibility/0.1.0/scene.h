#pragma once

#include <fuse_flow/rig_frame.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

/** \brief What stands in for your cameras in the examples: three of them, 10 cm apart along x, that look along z at a board,
 *  1 m away, in front of a wall, 1.5 m away. */
inline std::vector<fuse_flow::Camera> exampleCameras() {
  std::vector<fuse_flow::Camera> cameras;
  for (int i = 0; i < 3; ++i) {
    fuse_flow::Camera camera;
    camera.name = "camera " + std::to_string(i);
    camera.intrinsics = {640, 480, 525.0f, 525.0f, 319.5f, 239.5f, {}};
    camera.T_world_camera.translation().x() = 0.1 * (i - 1);
    cameras.push_back(camera);
  }
  return cameras;
}

/** \brief What a camera of the example measures, millimetres. */
inline std::vector<std::uint16_t> exampleDepth(const fuse_flow::Camera& camera) {
  const fuse_flow::Intrinsics& K = camera.intrinsics;
  std::vector<std::uint16_t> depth;
  for (int v = 0; v < K.height; ++v)
    for (int u = 0; u < K.width; ++u) {
      const double x = camera.T_world_camera.translation().x() + (u - K.cx) / K.fx;  // where the ray meets the board
      const double y = (v - K.cy) / K.fy;
      depth.push_back(std::abs(x) < 0.2 && std::abs(y) < 0.2 ? 1000 : 1500);
    }
  return depth;
}

/** \brief Whether a cloud has points, and all of them lie within 1 mm of the board or of the wall. */
template <typename Cloud>
bool onBoardOrWall(const Cloud& cloud) {
  std::size_t finite = 0;
  for (const auto& point : cloud) {
    if (!std::isfinite(point.z)) continue;
    ++finite;
    if (std::abs(point.z - 1.0f) > 1e-3f && std::abs(point.z - 1.5f) > 1e-3f) return false;
  }
  return finite > 1000;
}
