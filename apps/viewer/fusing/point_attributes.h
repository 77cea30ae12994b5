#pragma once

#include "simulation/surfaces/ray_scene.h"

#include <fuse_flow/point_types.h>
#include <fuse_flow/rig_frame.h>

#include <pcl/point_cloud.h>

#include <cstdint>
#include <vector>

namespace fuse_flow::viewing {

using Cloud = pcl::PointCloud<PointFused>;

/** \brief The measurement that a fused point came from. */
struct Origin {
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  std::uint32_t camera{kNone};  ///< kNone: no camera measured within 50 mm of the point
  int u{0};                     ///< pixel of its depth image
  int v{0};
};

/** \brief For each point the camera whose measurement on the point's ray lies nearest to it: its camera of origin, or the
 *  first among those that agree. */
std::vector<Origin> originsOf(const Cloud& cloud, const RigFrame& frame, int threads);

/** \brief Unit normals, world frame, of the depth images at the points' origins, over some ten pixels
 *  (pcl::IntegralImageNormalEstimation); zero where there is none. */
std::vector<Eigen::Vector3f> normalsOf(const std::vector<Origin>& origins, const RigFrame& frame, int threads);

/** \brief Of each point to the true surface, metres; infinite: over 1 m. */
std::vector<float> truthDistances(const Cloud& cloud, const simulation::RayScene& scene, int threads);

/** \brief The mean of that over at most 10,000 points, evenly spread over the cloud; metres, NaN if none is within 1 m. */
double meanTruthDistance(const Cloud& cloud, const simulation::RayScene& scene, int threads);

}  // namespace fuse_flow::viewing
