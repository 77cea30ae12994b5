#pragma once

#include <fuse_flow/math/confidence.h>
#include <fuse_flow/math/multipath.h>
#include <fuse_flow/math/noise_scale.h>
#include <fuse_flow/math/smoothing.h>
#include <fuse_flow/precompiled.h>
#include <fuse_flow/sensors/preprocessing.h>

namespace fuse_flow {

/** \brief What stays fixed in the world. Views determine only the poses of cameras relative to each other. */
enum class Gauge {
  Mean,        ///< the mean of all corrections is zero
  FirstCamera  ///< camera 0 keeps its pose
};

/** \brief How ExtrinsicEstimation finds and weights correspondences. */
struct ExtrinsicParameters {
  PreprocessingParameters preprocessing;  ///< raw depth to metres
  /** \brief Smoothing of the depth from which normals are computed; never wide, because the images are already reduced. */
  SmoothingParameters smoothing{3, 2.5f, 0.7f, 1e6f, false};
  /** \brief A block that sticks out of its surface on all sides, by at most this many standard deviations, is moved back to the surface
   *  before depth is smoothed for normals; ≥ 0. With 0, or without smoothing passes, no block is moved. The upper limit is for wide blocks,
   *  which have little noise: there, a block that sticks out is real shape. */
  float max_speckle{6.0f};
  NoiseModel noise;  ///< of the cameras without their own model, see Camera::noise
  /** \brief Side of the blocks that are averaged first, pixels; 1 … 16. */
  int reduction{2};
  /** \brief Views whose noise is more than this times the noise of that model are averaged over blocks with twice the side, if a row then
   *  has at least a hundred blocks; ≥ 0. So much noise is typical of sensors that match blocks. Neighbouring pixels share their errors, so
   *  small blocks hardly average them. */
  float coarse_above{1.8f};
  /** \brief Number of points of a view for which correspondences are searched, chosen evenly over the directions of their normals;
   *  ≥ 100. */
  int samples{12000};
  /** \brief Largest number of views that a view is compared with; those that overlap it most are chosen; ≥ 1. The cost is linear in
   *  this. */
  int max_neighbours{8};
  /** \brief Largest distance of a correspondence in the first iteration, metres; (0, 10]; see min_correspondence_distance. */
  float max_correspondence_distance{0.25f};
  /** \brief Largest distance in the last iterations, metres; (0, max_correspondence_distance]. Where three standard deviations of the noise are more,
   *  these count. */
  float min_correspondence_distance{0.03f};
  /** \brief Largest angle between the normals of a correspondence, radians; (0, π/2). */
  float max_normal_angle{0.7f};
  /** \brief A direction is estimated only if its information is at least this many times the information that noise alone would produce;
   *  ≥ 1. */
  float min_information{2.0f};
  /** \brief For cameras with a modulation frequency (Camera::multipath): s, indirect light from surfaces that no view measured, as a share
   *  of the direct light at a surface one metre away, divided by the reflectance ρ; 1/m²; ≥ 0. It increases the uncertainty of depth by s ρ
   *  c/(4π f) z²: multipath interference has most effect far away. At 0.035, ρ = 0.6 and f = 200 MHz, this is 10 mm at 2 m. */
  float residual_multipath{kResidualMultipath};
  /** \brief Use colour, if both views have it. It determines directions that geometry leaves open, and adds information to the others. */
  bool use_color{true};
  int max_iterations{50};           ///< ≥ 1
  Gauge gauge{Gauge::FirstCamera};  ///< what stays fixed
};

/** \brief The noise model in the form that shared functions of the fusion expect. */
inline ConfidenceParameters noiseParameters(const ExtrinsicParameters& parameters) {
  ConfidenceParameters confidence;
  confidence.noise = parameters.noise;
  return confidence;
}

/** \brief Side of a block, pixels. \param width of the image, pixels  \param noise_level of the view, see ViewNoise::level() */
inline int blockReduction(const ExtrinsicParameters& parameters, int width, float noise_level) {
  constexpr int fewest = 100;  // blocks in a row; smaller images look noisy because of their content
  const int coarse = 2 * parameters.reduction;
  return noise_level > parameters.coarse_above && width >= fewest * coarse ? coarse : parameters.reduction;
}

/** \brief Throws pcl::BadArgumentException for a value out of range. */
FUSE_FLOW_INLINE void checkParameters(const ExtrinsicParameters& parameters);

}  // namespace fuse_flow
