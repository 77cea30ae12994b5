#pragma once

#include <fuse_flow/rig_frame.h>

#include <pcl/point_cloud.h>

#include <cstddef>

namespace fuse_flow {

/** \brief Parameters that eq. 12 leaves open. */
struct ReprojectionQualityParameters {
  /** \brief A camera sees a point if the point projects inside, the depth there is valid and |z − D| is under this;
   *  metres; (0, 10]. */
  float visibility{0.05f};
  /** \brief An input pixel is covered if a fused point lies within this of it; metres; (0, 10]. */
  float coverage_radius{0.015f};
  /** \brief Coverage checks every n-th pixel in both directions; ≥ 1. */
  int coverage_step{1};
  float min_range{0.1f};   ///< nearest depth that counts as a measurement, metres; ≥ 0
  float max_range{20.0f};  ///< farthest, metres; > min_range, finite
};

/** \brief Throws pcl::BadArgumentException naming the parameter and its value if one is out of its range. */
inline void checkParameters(const ReprojectionQualityParameters& parameters);

/** \brief How well a cloud agrees with the views of a frame. Read all figures together: removing points alone improves E_MC. */
struct ReprojectionQuality {
  std::size_t points{0};             ///< of the cloud, finite or not
  std::size_t seen_points{0};        ///< by one view at least
  std::size_t multi_view_points{0};  ///< by two views or more
  std::size_t violating_points{0};   ///< well in front of the measurement of some view: they float in free space
  std::size_t pixels{0};             ///< measurements looked at
  std::size_t covered_pixels{0};     ///< of those, the ones with a fused point nearby
  double error{0};                   ///< E_MC of eq. 12 over the seen points, metres; NaN if there are none
  double multi_view_error{0};        ///< E_MC over the points that two or more views see, metres; NaN if there are none

  /** \brief Violating points of all points, 0 … 1; 0 for an empty cloud. */
  double violationShare() const {
    return points ? static_cast<double>(violating_points) / static_cast<double>(points) : 0.0;
  }
  /** \brief Covered pixels of all pixels, 0 … 1; 0 if there are none. */
  double coverage() const { return pixels ? static_cast<double>(covered_pixels) / static_cast<double>(pixels) : 0.0; }
};

/** \brief Computes eq. 12, and the figures that must be read together with it. Any number of threads may call it at once.
 *  \param cloud points in the world frame; any PCL point with x, y, z
 *  \param frame the views to compare with; they need not be those that the cloud was made from
 *  \param parameters what counts as seen and as covered
 *  \param threads 0: one per core
 *  \throws pcl::BadArgumentException if a camera or a view contradicts itself, or a parameter is out of its range */
template <typename PointT>
ReprojectionQuality reprojectionQuality(const pcl::PointCloud<PointT>& cloud, const RigFrame& frame,
                                        const ReprojectionQualityParameters& parameters = {}, unsigned int threads = 0);

}  // namespace fuse_flow

#include <fuse_flow/impl/quality/reprojection_quality.hpp>
