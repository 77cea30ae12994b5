#pragma once

#include "viewer/fusing/point_attributes.h"

#include <fuse_flow/camera.h>

#include <vector>

namespace fuse_flow::viewing {

/** \brief Where the viewer stands; world frame, metres. */
struct Viewpoint {
  Eigen::Vector3d from{Eigen::Vector3d::UnitX()};
  Eigen::Vector3d at{Eigen::Vector3d::Zero()};
  Eigen::Vector3d up{Eigen::Vector3d::UnitZ()};
  double angle{30};  ///< from the upper to the lower border, degrees
};

/** \brief A view of a cloud from beside the first camera and a little above it, upright as the cameras are. Of all of the cloud,
 *  unless that is from further away than the camera: there a wall may be, which the camera does not see through either. */
Viewpoint startViewpoint(const Cloud& cloud, const std::vector<Camera>& cameras);

/** \brief The same view, of all of a box. */
Viewpoint lookingAtAllOf(const Eigen::AlignedBox3d& box, const Viewpoint& view);

}  // namespace fuse_flow::viewing
