#pragma once

#include <fuse_flow/math/confidence.h>
#include <fuse_flow/math/multipath.h>
#include <fuse_flow/math/noise_scale.h>
#include <fuse_flow/math/smoothing.h>
#include <fuse_flow/precompiled.h>
#include <fuse_flow/sensors/preprocessing.h>

namespace fuse_flow {

/** \brief What of the rig stays where it is; views alone tell only where cameras are relative to each other. */
enum class Gauge {
  Mean,        ///< the mean of all corrections is none
  FirstCamera  ///< camera 0 stays
};

/** \brief How ExtrinsicEstimation finds and weighs what corresponds. */
struct ExtrinsicParameters {
  PreprocessingParameters preprocessing;  ///< raw depth to metres
  /** \brief Of the depth that normals are taken from; never wide, since images are reduced already. */
  SmoothingParameters smoothing{3, 2.5f, 0.7f, 1e6f};
  /** \brief A block that sticks out of its surface on all sides, by up to this many standard deviations, is brought back to it before depth
   *  is smoothed for normals; ≥ 0; 0, or no passes of smoothing: none is. Where blocks are so wide that they
   *  hardly have noise, what sticks out is shape. */
  float max_speckle{6.0f};
  NoiseModel noise;  ///< of the cameras that have no model of their own, see Camera::noise
  /** \brief Blocks of this many pixels, each way, are averaged first; 1 … 16. */
  int reduction{2};
  /** \brief Views with more than this times the noise of that model are averaged over blocks twice as large, each way, if a hundred of them
   *  fill a row; ≥ 0. So much noise is that of sensors that match blocks, whose errors near pixels share: two hardly average it. */
  float coarse_above{1.8f};
  /** \brief Points of a view that look for their counterparts, chosen evenly over the directions of their normals; ≥ 100. */
  int samples{12000};
  /** \brief Views that a view is compared with at most, those that it overlaps most; ≥ 1. The cost is linear in this. */
  int max_neighbours{8};
  /** \brief Farthest that a point may be from its counterpart in the first iteration, metres; (0, 10]; see min_distance. */
  float max_distance{0.25f};
  /** \brief Farthest in the last ones, metres, or three standard deviations where noise is more; (0, max_distance]. */
  float min_distance{0.03f};
  /** \brief Largest angle between the normals of counterparts, radians; (0, π/2). */
  float max_normal_angle{0.7f};
  /** \brief A direction moves only if the data tell it this many times better than noise alone would seem to; ≥ 1. */
  float min_information{2.0f};
  /** \brief Of cameras with a modulation frequency (Camera::multipath): light that comes by way of what no view measured, as a share of
   *  what comes straight to a surface one metre away, over the reflectance; 1/m²; ≥ 0. Depth counts as uncertain by s ρ c/(4π f) z²
   *  more: what multipath bends lies far away. At 0.035, ρ = 0.6 and f = 200 MHz, 10 mm at 2 m. */
  float residual_multipath{kResidualMultipath};
  /** \brief Use colour, where both views have it: it tells what geometry leaves open, and adds to what it tells. */
  bool use_color{true};
  int max_iterations{50};           ///< ≥ 1
  Gauge gauge{Gauge::FirstCamera};  ///< what stays
};

/** \brief For what is shared with fusion, which has the noise among its parameters of confidence. */
inline ConfidenceParameters noiseParameters(const ExtrinsicParameters& parameters) {
  ConfidenceParameters confidence;
  confidence.noise = parameters.noise;
  return confidence;
}

/** \brief Pixels of a block, each way. \param width of the image, pixels  \param noise_level of the view, see ViewNoise::level() */
inline int blockReduction(const ExtrinsicParameters& parameters, int width, float noise_level) {
  constexpr int fewest = 100;  // blocks in a row; images of fewer look noisy by what they show
  const int coarse = 2 * parameters.reduction;
  return noise_level > parameters.coarse_above && width >= fewest * coarse ? coarse : parameters.reduction;
}

/** \brief Throws pcl::BadArgumentException for a value out of range. */
FUSE_FLOW_INLINE void checkParameters(const ExtrinsicParameters& parameters);

}  // namespace fuse_flow
