#pragma once

#include <fuse_flow/impl/camera.hpp>
#include <fuse_flow/stereo/stereo_frame.h>

namespace fuse_flow {

inline Camera stereoCamera(const Camera& camera) {
  Camera own;
  own.name = camera.name;
  own.intrinsics = camera.color ? camera.color->intrinsics : camera.intrinsics;
  own.T_world_camera = camera.T_world_camera;
  if (camera.color) own.T_world_camera = camera.T_world_camera * camera.color->T_depth_color;
  return own;
}

}  // namespace fuse_flow
