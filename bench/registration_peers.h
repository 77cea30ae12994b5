#pragma once

/** \file
 *  \brief What PCL has for the poses of a rig: GICP from pair to pair, and LUM over all pairs. */

#include <fuse_flow/rig_frame.h>

#include <Eigen/Geometry>

#include <utility>
#include <vector>

namespace bench {

struct PeerResult {
  std::vector<Eigen::Isometry3d> T_world_camera;
  double milliseconds{0};
};

/** \brief pcl::GeneralizedIterativeClosestPoint along the maximum spanning tree of the overlaps, from camera 0 on. Clouds thinned
 *  by pcl::VoxelGrid at leaf metres. \param overlaps pairs of cameras, the largest overlap first */
PeerResult gicpAlongTree(const fuse_flow::RigFrame& frame, const std::vector<Eigen::Isometry3d>& initial,
                         const std::vector<std::pair<std::size_t, std::size_t>>& overlaps, float leaf,
                         float max_distance);

/** \brief pcl::registration::LUM over all overlaps, with correspondences found anew `rounds` times, their reach shrinking. */
PeerResult lum(const fuse_flow::RigFrame& frame, const std::vector<Eigen::Isometry3d>& initial,
               const std::vector<std::pair<std::size_t, std::size_t>>& overlaps, float leaf, float max_distance,
               int rounds);

}  // namespace bench
