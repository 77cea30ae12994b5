#pragma once

#include <fuse_flow/math/vec3.h>
#include <fuse_flow/rig_frame.h>

#include <pcl/point_cloud.h>

#include <vector>

namespace fuse_flow {
namespace detail {

/** \brief The origin of measures: the middle of the cameras. In single precision a place 48 km from the world's origin is known to
 *  4 mm, and what is computed there to several times that; from here it is not computed there. */
inline Eigen::Vector3d middleOf(const RigFrame& frame) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Camera& camera : frame.cameras) sum += camera.T_world_camera.translation();
  return frame.cameras.empty() ? sum : Eigen::Vector3d(sum / static_cast<double>(frame.cameras.size()));
}

inline RigFrame movedTo(const Eigen::Vector3d& origin, RigFrame frame) {
  for (Camera& camera : frame.cameras) camera.T_world_camera.translation() -= origin;
  return frame;
}

/** \brief The finite points of a cloud, from an origin. */
template <typename PointT>
std::vector<Vec3> pointsFrom(const Eigen::Vector3d& origin, const pcl::PointCloud<PointT>& cloud) {
  std::vector<Vec3> points;
  points.reserve(cloud.size());
  for (const PointT& point : cloud) {
    const Vec3 p{point.x, point.y, point.z};
    if (!isFinite(p)) continue;
    const Vec3 q{static_cast<float>(static_cast<double>(p.x) - origin.x()),
                 static_cast<float>(static_cast<double>(p.y) - origin.y()),
                 static_cast<float>(static_cast<double>(p.z) - origin.z())};
    if (isFinite(q)) points.push_back(q);
  }
  return points;
}

}  // namespace detail
}  // namespace fuse_flow
