#pragma once

#include <fuse_flow/math/confidence.h>

namespace fuse_flow {

/** \brief How the D^r of eq. 8 is made from the measured depth: passes over 3×3 neighbourhoods whose spacing doubles from
 *  pass to pass (1, 2, 4, 8 pixels, twice that in noisy views), in which a neighbour counts only if it lies on the surface of the pixel,
 *  within the noise. The passes work on inverse depth q = 1/z. On every plane q is an affine function of the pixel, so planes keep their
 *  place exactly with a lens without distortion, and nearly with a lens whose distortion is affine within the reach of a pass. For sensors
 *  that triangulate, the noise of q is the same everywhere. The paper says "refined depth", but does not define it.
 *
 *  An average lies inside a curved surface: a sphere of radius R shrinks, in inverse depth, by 57 / (f² R) after four passes over all
 *  neighbours, with a focal length of f pixels. A person's arm would be several millimetres too thin. Tukey's twicing (Exploratory Data
 *  Analysis, 1977) gives that back: the wide passes run once more, and what they change is subtracted, where it is more than noise. */
struct SmoothingParameters {
  /** \brief 0 … 4; 0: D^r is the measured depth. */
  int passes{4};
  /** \brief A pair of opposite neighbours counts if its second difference is under this many standard deviations of the second difference
   *  by noise alone; > 0. */
  float tolerance{2.8f};
  /** \brief The tolerance of a pass divided by that of the previous pass, which has reduced the noise; (0, 1]. */
  float shrink{0.7f};
  /** \brief Views with more than this times the noise of ConfidenceParameters::noise are smoothed at twice the spacing; ≥ 0. So much noise
   *  is typical of sensors that match blocks. Their neighbouring pixels share errors, so averaging these pixels gains nothing. Coarse
   *  images, in which surfaces curve within kNoiseSpacing pixels, look equally noisy: raise this value for them. Consistency takes
   *  the normals of such views from pixels 4 away instead of 1 (ConsistencyParameters::min_facing). */
  float wide_above{1.8f};
  /** \brief Whether curved surfaces get back what the passes took from them, twicedInverseDepth(); needs two passes or more. */
  bool twicing{true};
  /** \brief A change that twicing subtracts half of, in standard deviations of the view's noise before smoothing; ≥ 0. What is smaller is
   *  taken for noise and stays, so that with four passes planes are nearly as smooth as without twicing; what is larger is taken for curvature. */
  float twicing_above{0.2f};
};

constexpr int kMaxSmoothingPasses = 4;
/** \brief Distance of the farthest pixel that a pass reads. */
constexpr int kMaxSmoothingStep = 1 << kMaxSmoothingPasses;

/** \brief How many of the passes twicing runs once more: all but the first, in which a curved surface loses next to nothing; of two
 *  both. */
FUSE_FLOW_HD int twicingPasses(const SmoothingParameters& p) {
  return p.twicing && p.passes > 1 ? (p.passes > 2 ? p.passes - 1 : 2) : 0;
}

/** \brief All passes, those of twicing included, which come last. */
FUSE_FLOW_HD int smoothingPasses(const SmoothingParameters& p) { return p.passes + twicingPasses(p); }

/** \brief The pass that a pass repeats; itself, unless it is one of twicing's. \param pass 0 … smoothingPasses() − 1 */
FUSE_FLOW_HD int repeatedPass(const SmoothingParameters& p, int pass) {
  return pass < p.passes ? pass : pass - twicingPasses(p);
}

/** \brief Which of three maps a pass reads; it writes the one of the pass after it. The passes of twicing leave alone the map of pass `passes`,
 *  which the last one looks at. \param pass 0 … smoothingPasses(), that is the result's  \return 0 … 2; 0 for the first pass, 2 only with
 *  twicing */
FUSE_FLOW_HD int smoothingMap(const SmoothingParameters& p, int pass) {
  if (pass <= p.passes) return pass % 2;
  return (pass - p.passes) % 2 == 1 ? 1 - p.passes % 2 : 2;
}

/** \brief Distance between the pixels of a pass's neighbourhood. \param pass 0 … smoothingPasses() − 1
 *  \param noise_level ViewNoise::level() */
FUSE_FLOW_HD int smoothingStep(const SmoothingParameters& p, int pass, float noise_level) {
  return (noise_level > p.wide_above ? 2 : 1) << repeatedPass(p, pass);
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
  for (int k = 0; k < repeatedPass(p, pass); ++k) tolerance *= p.shrink;
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

/** \brief Twicing: q_s − s d with d = k (S q_s − q_s). On a surface of constant curvature a pass at the spacing h changes q by a multiple
 *  of h², so d is what all passes have changed if k is Σ h² over all of them / Σ h² over those that run twice. The share
 *  s = x⁴ / (x⁴ + a⁴) of x = d / noise leaves what may be noise. A pixel that sticks out by itself, by more than d beside its neighbours both
 *  along the row and along the column, is not curved, but wrong: s is 0 for it.
 *  \param cross q_s, inverse depth after all passes but those of twicing, of the pixel and of those beside it: left, right, above, below, 1/metres,
 *  0 for holes  \param again S q_s, after those, too, 1/metres  \param noise standard deviation of the measured q, 1/metres, > 0
 *  \return 1/metres, > 0 */
FUSE_FLOW_HD float twicedInverseDepth(const SmoothingParameters& p, const float (&cross)[5], float again, float noise) {
  const float smoothed = cross[0];
  const float all = static_cast<float>((1 << 2 * p.passes) - 1);  // 3 Σ h²
  const float change =
      all / (all + 1 - static_cast<float>(1 << 2 * (p.passes - twicingPasses(p)))) * (again - smoothed);
  const float x = change / noise;
  const float x2 = x * x, a2 = p.twicing_above * p.twicing_above;
  const float share = x2 * x2 / (x2 * x2 + a2 * a2 + 1e-20f);  // the last term: where neither is more than 0
  const auto continues = [&](float before, float after) {
    const float r = before - 2 * smoothed + after;
    return (before > 0) & (after > 0) & (r * r <= change * change);
  };
  const float curved = continues(cross[1], cross[2]) | continues(cross[3], cross[4]) ? share : 0.0f;
  const float twiced = smoothed - curved * change;
  return twiced > 0 ? twiced : smoothed;
}

}  // namespace fuse_flow
