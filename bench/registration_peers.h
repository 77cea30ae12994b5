#pragma once

/** \file
 *  \brief What PCL has for the poses of a rig: GICP from pair to pair, and LUM over all pairs; without poses, FPFH. */

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

/** \brief Poses from nothing: FPFH of every pair of clouds matched by pcl::SampleConsensusPrerejective; then along the maximum
 *  spanning tree of the inliers, from camera 0 on. A camera that no pair connects stays at the identity. */
PeerResult fpfhAlongTree(const fuse_flow::RigFrame& frame, float leaf);

}  // namespace bench
