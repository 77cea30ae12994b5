#pragma once

#include "viewer/point_attributes.h"

#include <fuse_flow/camera.h>

#include <vector>

namespace fuse_flow::viewing {

/** \brief Where the viewer stands; world frame, metres. */
struct Viewpoint {
  Eigen::Vector3d from{Eigen::Vector3d::UnitX()};
  Eigen::Vector3d at{Eigen::Vector3d::Zero()};
  Eigen::Vector3d up{Eigen::Vector3d::UnitZ()};
};

/** \brief A view of a whole cloud from beside the first camera and a little above it, upright as the cameras are. */
Viewpoint startViewpoint(const Cloud& cloud, const std::vector<Camera>& cameras);

}  // namespace fuse_flow::viewing
