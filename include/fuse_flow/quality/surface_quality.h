#pragma once

#include <fuse_flow/math/confidence.h>
#include <fuse_flow/rig_frame.h>

#include <pcl/point_cloud.h>

#include <cstddef>
#include <limits>

/** \file
 *  \brief What can be said of a fused surface where nobody knows the truth: from the cloud itself and from the depth views. No figure tells
 *  all: a bent, smooth surface has no noise, and a cloud of few points no double surfaces. Compare clouds of one recording. */

namespace fuse_flow {

struct SurfaceQualityParameters {
  /** \brief Radius of the piece of surface around a point that counts as a plane, metres; (0, 1]. */
  float neighborhood{0.03f};
  /** \brief As in ReprojectionQualityParameters: a camera sees a point if |z − D| is under this, metres; > 0. */
  float visibility{0.05f};
  /** \brief Pixels around the one that a point falls on, each way, that must lie behind it, too; 0 … 8. */
  int silhouette{2};
  /** \brief Two sheets are one surface seen double if they are this far apart, metres; > 0. */
  float min_separation{0.005f};
  float max_separation{0.05f};  ///< … and no farther than this, metres; > min_separation
  /** \brief A measurement is covered if a fused point lies within this of it, metres; > 0 … */
  float coverage_radius{0.015f};
  /** \brief … or within so many standard deviations of the sensor's noise at its depth; ≥ 0 … */
  float coverage_deviations{3.0f};
  /** \brief … but no farther than this, metres; ≥ coverage_radius. */
  float max_coverage_radius{0.06f};
  /** \brief Every how many pixels, each way, coverage looks at; ≥ 1. */
  int coverage_step{2};
  /** \brief What moves by less than this from frame to frame counts as standing still, metres; ≥ 0. So does what moves by less
   *  than the depth's own noise. */
  float max_motion{0.005f};
  /** \brief Points whose surroundings are looked at, spread evenly over the cloud's numbers; 0: all. */
  std::size_t samples{20000};
  float min_range{0.1f};   ///< nearest depth that counts as a measurement, metres; ≥ 0
  float max_range{20.0f};  ///< farthest, metres; > min_range, finite
  /** \brief Of the cameras that have no model of their own (Camera::noise), scaled by what each view is measured to have. */
  NoiseModel noise;
};

/** \brief Throws pcl::BadArgumentException naming the parameter and its value if one is out of its range. */
inline void checkParameters(const SurfaceQualityParameters& parameters);

/** \brief How much a surface that does not move jumps from one frame to the next. */
struct TemporalFlicker {
  std::size_t points{0};  ///< looked at, on what does not move
  double sum{
      0};  ///< of their jumps along the surface's normal, metres; one that is gone counts as the neighbourhood's radius

  /** \brief Mean jump, metres; NaN if nothing is known to stand still. */
  double mean() const {
    return points > 0 ? sum / static_cast<double>(points) : std::numeric_limits<double>::quiet_NaN();
  }
};

/** \brief Counts and sums, which add up over frames, and the figures made of them; NaN where there was nothing to measure. */
struct SurfaceQuality {
  std::size_t points{0};          ///< of the cloud, finite
  std::size_t sampled_points{0};  ///< whose surroundings were looked at
  std::size_t surface_points{
      0};  ///< of those, the ones with six points or more in their neighbourhood, which have a local plane
  std::size_t judged_points{0};     ///< of those, the ones with enough points around to tell one sheet from two
  std::size_t double_points{0};     ///< of those, the ones beside a second sheet that faces the same way
  std::size_t violating_points{0};  ///< of the cloud: in front of all that a view measured around them
  std::size_t pixels{0};            ///< measurements looked at
  std::size_t covered_pixels{0};    ///< of those, the ones with a fused point as near as the sensor's noise lets it be
  double noise_sum{0};      ///< over the surface points, of the deviation of the cloud from their local planes, metres
  TemporalFlicker flicker;  ///< from the frame before; see temporalFlicker()

  /** \brief Noise of the surface: mean over its points of the RMS distance of the points in the neighbourhood to the plane that fits
   *  them best, metres. Shape counts too: on a ball of radius R it is r² / √12 / 2R, 1.3 mm at 100 mm. */
  double noise() const { return share(noise_sum, surface_points); }
  /** \brief Share of the judged points beside a second sheet, 0 … 1: the same surface as two cameras put it, and true steps. */
  double doubleSurfaces() const { return share(static_cast<double>(double_points), judged_points); }
  /** \brief Share of the points that float in space known to be free, away from silhouettes, 0 … 1. */
  double violationShare() const { return share(static_cast<double>(violating_points), points); }
  /** \brief Share of the measurements that are covered, 0 … 1. */
  double coverage() const { return share(static_cast<double>(covered_pixels), pixels); }

  SurfaceQuality& operator+=(const SurfaceQuality& more);

 private:
  static double share(double part, std::size_t all) {
    return all > 0 ? part / static_cast<double>(all) : std::numeric_limits<double>::quiet_NaN();
  }
};

/** \brief The measures of one cloud, all but flicker.
 *
 *  - Noise: see SurfaceQuality::noise().
 *  - Double surfaces: around a point the cloud is looked at along the surface's normal, in a cylinder of 0.8 neighbourhoods' radius,
 *    as far as max_separation; only what faces the camera from the same side counts, so that the back of a board does not. The
 *    heights are cut in two where that explains most of their variance. They are two sheets if those lie min_separation to
 *    max_separation apart, each with a fifth of the points, and Ashman's D (Ashman, Bird and Zepf, Astronomical Journal 108, 1994)
 *    is 4 or more: noise alone, however much of it, has 2.7 (normal) to 3.5 (uniform).
 *  - Free-space violations away from silhouettes: z < D − visibility for the nearest valid D of all pixels around. At the exact
 *    pixel, poses a few millimetres off make true surface at edges count as violating, and deleting it look good.
 *  - Coverage with a radius that grows with the noise which the sensor has there.
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
 *  \param before the cloud before this one  \param before_frame what it was made from; the same cameras, and its images must still be there
 *  \param after this cloud  \param after_frame what it was made from
 *  \throws pcl::BadArgumentException as surfaceQuality(), or if the frames have another number of cameras */
template <typename PointT>
TemporalFlicker temporalFlicker(const pcl::PointCloud<PointT>& before, const RigFrame& before_frame,
                                const pcl::PointCloud<PointT>& after, const RigFrame& after_frame,
                                const SurfaceQualityParameters& parameters = {}, unsigned int threads = 0);

}  // namespace fuse_flow

#include <fuse_flow/impl/quality/surface_quality.hpp>
