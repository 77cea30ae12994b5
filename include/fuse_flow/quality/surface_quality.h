#pragma once

#include <fuse_flow/math/confidence.h>
#include <fuse_flow/rig_frame.h>

#include <pcl/point_cloud.h>

#include <cstddef>
#include <limits>

/** \file
 *  \brief Figures of quality of a fused surface without ground truth, from the cloud itself and from the depth views. No single figure is
 *  sufficient: a bent, smooth surface has no noise, and a cloud of few points has no double surfaces. Compare only clouds of one
 *  recording. */

namespace fuse_flow {

/** \brief What surfaceQuality() and temporalFlicker() look at. */
struct SurfaceQualityParameters {
  /** \brief Radius of the piece of surface around a point that counts as a plane, metres; (0, 1]. */
  float neighborhood{0.03f};
  /** \brief As in ReprojectionQualityParameters: a camera sees a point if |z − D| is under this, metres; > 0. */
  float visibility{0.05f};
  /** \brief A point violates free space only if all pixels at most this far from its pixel, in each direction, lie behind it; 0 … 8. */
  int silhouette{2};
  /** \brief Two sheets are a double surface if they are at least this far apart, metres; > 0. */
  float min_separation{0.005f};
  float max_separation{0.05f};  ///< … and no farther than this, metres; > min_separation
  /** \brief A measurement is covered if a fused point lies within this of it, metres; > 0 … */
  float coverage_radius{0.015f};
  /** \brief … or within so many standard deviations of the sensor's noise at its depth; ≥ 0 … */
  float coverage_deviations{3.0f};
  /** \brief … but no farther than this, metres; ≥ coverage_radius. */
  float max_coverage_radius{0.06f};
  /** \brief Coverage checks every n-th pixel in both directions; ≥ 1. */
  int coverage_step{2};
  /** \brief A surface that moves by less than this from frame to frame counts as static, metres; ≥ 0. A surface that moves by less than the
   *  noise of its depth also counts as static. */
  float max_motion{0.005f};
  /** \brief Number of points whose neighbourhood is examined, spread evenly over the indices of the cloud; 0: all points. */
  std::size_t samples{20000};
  float min_range{0.1f};   ///< nearest depth that counts as a measurement, metres; ≥ 0
  float max_range{20.0f};  ///< farthest, metres; > min_range, finite
  /** \brief Noise model of the cameras without their own model (Camera::noise). The measured noise scale of each view multiplies it. */
  NoiseModel noise;
};

/** \brief Throws pcl::BadArgumentException naming the parameter and its value if one is out of its range. */
inline void checkParameters(const SurfaceQualityParameters& parameters);

/** \brief How much a static surface jumps from one frame to the next. */
struct TemporalFlicker {
  std::size_t points{0};  ///< examined points on static surfaces
  double sum{
      0};  ///< of their jumps along the surface normal, metres; a missing point counts as the radius of the neighbourhood

  /** \brief Mean jump, metres; NaN if no surface is known to be static. */
  double mean() const {
    return points > 0 ? sum / static_cast<double>(points) : std::numeric_limits<double>::quiet_NaN();
  }
};

/** \brief Counts and sums, which can be added over frames, and the figures computed from them. A figure is NaN if there was nothing to
 *  measure. */
struct SurfaceQuality {
  std::size_t points{0};          ///< of the cloud, finite
  std::size_t sampled_points{0};  ///< points whose neighbourhood was examined
  std::size_t surface_points{
      0};  ///< of those, the ones with six points or more in their neighbourhood, which have a local plane
  std::size_t judged_points{0};     ///< of those, the ones with enough neighbours to distinguish one sheet from two
  std::size_t double_points{0};     ///< of those, the ones beside a second sheet that faces the same way
  std::size_t violating_points{0};  ///< points of the cloud in front of everything that a view measured around them
  std::size_t pixels{0};            ///< measurements looked at
  std::size_t covered_pixels{0};    ///< of those, the ones with a fused point within the sensor's noise
  double noise_sum{0};      ///< over the surface points, of the deviation of the cloud from their local planes, metres
  TemporalFlicker flicker;  ///< from the frame before; see temporalFlicker()

  /** \brief Noise of the surface: mean over its points of the RMS distance of the points in the neighbourhood to the plane that fits
   *  them best, metres. Shape counts too: on a ball of radius R it is r² / √12 / 2R, 1.3 mm at 100 mm. */
  double noise() const { return share(noise_sum, surface_points); }
  /** \brief Share of the judged points beside a second sheet, 0 … 1: surfaces that two cameras place differently, and true steps. */
  double doubleSurfaces() const { return share(static_cast<double>(double_points), judged_points); }
  /** \brief Share of the points that float in free space, away from silhouettes, 0 … 1. */
  double violationShare() const { return share(static_cast<double>(violating_points), points); }
  /** \brief Share of the measurements that are covered, 0 … 1. */
  double coverage() const { return share(static_cast<double>(covered_pixels), pixels); }

  /** \brief Adds the counts and sums of another frame, or part of one. */
  SurfaceQuality& operator+=(const SurfaceQuality& more);

 private:
  static double share(double part, std::size_t all) {
    return all > 0 ? part / static_cast<double>(all) : std::numeric_limits<double>::quiet_NaN();
  }
};

/** \brief The measures of one cloud, all but flicker.
 *
 *  - Noise: see SurfaceQuality::noise().
 *  - Double surfaces: around a point, the cloud is examined along the surface normal, in a cylinder of 0.8 neighbourhoods' radius,
 *    as far as max_separation; only points that face the same side count, so the back of a board does not count. The heights are divided
 *    into two groups, where this explains most of their variance. The groups are two sheets if they lie min_separation to max_separation
 *    apart, each with at least a fifth of the points, and Ashman's D (Ashman, Bird and Zepf, Astronomical Journal 108, 1994)
 *    is 4 or more: noise alone, however much of it, has 2.7 (normal) to 3.5 (uniform).
 *  - Free-space violations away from silhouettes: z < D − visibility for the nearest valid D of all pixels around. If only the exact pixel
 *    were used, poses that are a few millimetres off would make true points at edges count as violations, and deleting these points would
 *    look good.
 *  - Coverage, with a radius that grows with the noise of the sensor at that depth.
 *
 *  \param cloud points in the world frame; any PCL point with x, y, z
 *  \param frame the views to compare with; they need not be those that the cloud was made from
 *  \param parameters radii and limits
 *  \param threads 0: one per core
 *  \throws pcl::BadArgumentException if a camera or a view contradicts itself, or a parameter is out of its range */
template <typename PointT>
SurfaceQuality surfaceQuality(const pcl::PointCloud<PointT>& cloud, const RigFrame& frame,
                              const SurfaceQualityParameters& parameters = {}, unsigned int threads = 0);

/** \brief How much a cloud jumps from one frame to the next where nothing moves: for points of either cloud the distance, along the
 *  local plane's normal, to the other cloud's point beside it. A point counts where a camera sees it, and where no camera that
 *  sees it measures that the depth around (7 × 7 pixels) has changed: by more than max_motion in the mean, and than the standard
 *  deviation of its changes.
 *  \param before the cloud before this one  \param before_frame the frame that it was made from; it has the same cameras, and its images
 *  must still exist
 *  \param after this cloud  \param after_frame the frame that it was made from
 *  \param parameters as of surfaceQuality()  \param threads to use; 0: one per core
 *  \throws pcl::BadArgumentException as surfaceQuality(), or if the frames have another number of cameras */
template <typename PointT>
TemporalFlicker temporalFlicker(const pcl::PointCloud<PointT>& before, const RigFrame& before_frame,
                                const pcl::PointCloud<PointT>& after, const RigFrame& after_frame,
                                const SurfaceQualityParameters& parameters = {}, unsigned int threads = 0);

}  // namespace fuse_flow

#include <fuse_flow/impl/quality/surface_quality.hpp>
