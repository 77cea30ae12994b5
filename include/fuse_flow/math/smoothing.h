#pragma once

#include <fuse_flow/math/confidence.h>

namespace fuse_flow {

/** \brief How the D^r of eq. 8 is made from the measured depth: passes over 3×3 neighbourhoods whose spacing doubles from
 *  pass to pass (1, 2, 4, 8 pixels, twice that in noisy views), in which a neighbour counts only if it lies on the surface of the pixel,
 *  within the noise. The passes work on inverse depth q = 1/z. On every plane q is an affine function of the pixel, so planes keep their
 *  place exactly with a lens without distortion, and nearly with a lens whose distortion is affine within the reach of a pass. For sensors
 *  that triangulate, the noise of q is the same everywhere. The paper says "refined depth", but does not define it. */
struct SmoothingParameters {
  /** \brief 0 … 4; 0: D^r is the measured depth. */
  int passes{4};
  /** \brief A pair of opposite neighbours counts if its second difference is under this many standard deviations of the second difference
   *  by noise alone; > 0. */
  float tolerance{2.5f};
  /** \brief The tolerance of a pass divided by that of the previous pass, which has reduced the noise; (0, 1]. */
  float shrink{0.7f};
  /** \brief Views with more than this times the noise of ConfidenceParameters::noise are smoothed at twice the spacing; ≥ 0. So much noise
   *  is typical of sensors that match blocks. Their neighbouring pixels share errors, so averaging these pixels gains nothing. Coarse
   *  images, in which surfaces curve within kNoiseSpacing pixels, look equally noisy: raise this value for them. Consistency takes
   *  the normals of such views from pixels 4 away instead of 1 (ConsistencyParameters::min_facing). */
  float wide_above{1.8f};
};

constexpr int kMaxSmoothingPasses = 4;
/** \brief Distance of the farthest pixel that a pass reads. */
constexpr int kMaxSmoothingStep = 1 << kMaxSmoothingPasses;

/** \brief Distance between the pixels of a pass's neighbourhood. \param pass 0 … passes − 1
 *  \param noise_level ViewNoise::level() */
FUSE_FLOW_HD int smoothingStep(const SmoothingParameters& p, int pass, float noise_level) {
  return noise_level > p.wide_above ? 2 << pass : 1 << pass;
}

/** \brief Most that normalSpacing() gives, pixels. */
constexpr int kWideNormalSpacing = 4;

/** \brief Distance to the pixels from which the normal of a surface is taken: where neighbours share their errors, near ones say
 *  little. \param noise_level ViewNoise::level() */
FUSE_FLOW_HD int normalSpacing(const SmoothingParameters& p, float noise_level) {
  return noise_level > p.wide_above ? kWideNormalSpacing : 1;
}

/** \brief Of a pass: the largest second difference that counts, in units of the noise. Independent noise σ gives second
 *  differences √6 σ. \param noise_scale noiseScale() of the view */
FUSE_FLOW_HD float smoothingTolerance(const SmoothingParameters& p, int pass, float noise_scale) {
  float tolerance = 2.449490f * p.tolerance * noise_scale;
  for (int k = 0; k < pass; ++k) tolerance *= p.shrink;
  return tolerance;
}

/** \brief One pass at one pixel. The four pairs of opposite neighbours have second differences r = q₋ − 2 q₀ + q₊; each
 *  weighs w = (1 − (r/t)²)² inside the tolerance t (Tukey's biweight). q₀ + Σ w r / (1 + 2 Σ w) is the weighted mean of q₀
 *  and its neighbours. Pixels beyond a jump in depth, pixels without an opposite neighbour, and holes do not count.
 *  \param q inverse depths of the 3×3 pixels at the pass's spacing, row by row, 1/metres, 0 for holes; q[4], the pixel
 *  itself, is none  \param tolerance t, 1/metres */
FUSE_FLOW_HD float smoothedInverseDepth(const float (&q)[9], float tolerance) {
  const float per_tolerance = 1.0f / tolerance;
  float sum_weights = 0, sum = 0;
  const auto add = [&](float before, float after) {
    const float there = before > 0 ? (after > 0 ? 1.0f : 0.0f) : 0.0f;
    const float r = before - 2 * q[4] + after;
    const float x = r * per_tolerance;
    const float inside = 1.0f - x * x;
    const float root = inside > 0 ? inside : 0.0f;
    const float w = there * (root * root);
    sum_weights += w;
    sum += w * r;
  };
  add(q[3], q[5]);
  add(q[1], q[7]);
  add(q[0], q[8]);
  add(q[2], q[6]);
  return q[4] + sum / (1.0f + 2.0f * sum_weights);
}

}  // namespace fuse_flow
