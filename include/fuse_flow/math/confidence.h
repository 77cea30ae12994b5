#pragma once

#include <fuse_flow/math/host_device.h>
#include <fuse_flow/math/noise_model.h>

#include <cfloat>
#include <cmath>

namespace fuse_flow {

/** \brief How the gradient G and the spread σ_local of eq. 3 are measured in the 3×3 neighbourhood of a pixel. */
enum class ConfidenceForm {
  /** \brief As published: G is the norm of the central differences, σ_local the standard deviation about the mean. A plane that is seen at
   *  an angle then looks like noise. */
  Published,
  /** \brief Both are relative to the local plane and to the sensor's axial noise at that depth: σ_local comes from the second differences,
   *  G from the amount by which the slope exceeds that of a surface seen at max_incidence. */
  SlopeCompensated,
  /** \brief A measure of the user: C is DepthView::confidence, in [0, 1], which every view must have. First,
   *  FuseFlowParameters::min_confidence drops measurements; then the gate of eq. 9 tests C. C is the weight of the measurements that
   *  pass. */
  Given
};

/** \brief Parameters of eq. 3 and 9. */
struct ConfidenceParameters {
  /** \brief How G and σ_local are measured. */
  ConfidenceForm form{ConfidenceForm::SlopeCompensated};
  float alpha{0.5f};  ///< α, weight of the gradient term; ≥ 0
  float beta{0.5f};   ///< β, per length unit; ≥ 0
  float gamma{1.0f};  ///< γ, weight of the spread term; ≥ 0, α + γ > 0
  float delta{1.0f};  ///< δ, per length unit; ≥ 0
  /** \brief τ of eq. 9 on the normalised scale C ∈ [0, 1]. On this scale the published 0.6 of α + γ = 1.5 is 0.4. At 0.6 each of the two
   *  terms alone can close the gate, and a pixel without neighbours does not pass. The frame pipeline asks for it only where noise is more
   *  than FuseFlowParameters::gate_noise. */
  float threshold{0.6f};
  /** \brief Unit of G and σ_local, metres; (0, 10]. The paper names no unit; the default is centimetres. */
  float length_unit{0.01f};
  /** \brief Noise model of the cameras without their own model, see Camera::noise. SlopeCompensated divides by the σ(z) of a camera, in
   *  units of the σ of this model at noise_reference metres. */
  NoiseModel noise;
  float noise_reference{1.0f};  ///< metres; (0, 1000]
  /** \brief SlopeCompensated: a surface seen at more than this angle from its normal counts as a jump; radians, (0,
   *  π/2). */
  float max_incidence{1.3f};
};

/** \brief The noise of a view before it is measured. \param own model of its camera; null: the camera has none, and the model of the
 *  parameters is used */
FUSE_FLOW_HD ViewNoise viewNoise(const ConfidenceParameters& p, const NoiseModel* own) {
  if (own == nullptr) return {p.noise, 1.0f, 1.0f};
  return {*own, 1.0f, axialNoise(*own, p.noise_reference) / axialNoise(p.noise, p.noise_reference)};
}

/** \brief Eq. 3, divided by α + γ so that C ∈ (0, 1] as eq. 2 says. G and sigma_local in length units. */
FUSE_FLOW_HD float confidence(const ConfidenceParameters& p, float G, float sigma_local) {
  const float g = 1.0f + p.beta * G;
  const float s = 1.0f + p.delta * sigma_local;
  return (p.alpha * s + p.gamma * g) / (g * s * (p.alpha + p.gamma));  // one division instead of three
}

/** \brief The 3×3 neighbourhood of a depth pixel, row by row, metres; 0 where there is no measurement. Also used for other values, such as
 *  weights. */
struct DepthPatch {
  float z[9];  ///< z[4] is the pixel itself
};

// The two forms below run for every pixel of every frame: no branches, so that compilers turn a row into vector code.

/** \brief Published form: G from central differences (one-sided at holes), σ_local over the valid pixels about their
 *  mean. */
FUSE_FLOW_HD float confidencePublished(const ConfidenceParameters& p, const DepthPatch& patch) {
  const float* z = patch.z;
  const float centre = z[4];
  // Central difference where both neighbours are there, else one-sided, else none.
  const auto difference = [centre](float before, float after) {
    const float steps = (before > 0 ? 1.0f : 0.0f) + (after > 0 ? 1.0f : 0.0f);
    const float b = before > 0 ? before : centre;
    const float a = after > 0 ? after : centre;
    return (a - b) / (steps > 1 ? 2.0f : 1.0f);
  };
  const float gx = difference(z[3], z[5]);
  const float gy = difference(z[1], z[7]);
  float n = 1, sum = 0, sum_squares = 0;  // the centre, which differs from itself by nothing
  for (int i = 0; i < 9; ++i) {
    if (i == 4) continue;
    const float valid = z[i] > 0 ? 1.0f : 0.0f;
    const float d = valid * (z[i] - centre);  // about the centre: no cancellation
    n += valid;
    sum += d;
    sum_squares += d * d;
  }
  const float per_n = 1.0f / n;
  const float mean = sum * per_n;
  const float variance = sum_squares * per_n - mean * mean;
  const float unit = 1.0f / p.length_unit;
  return confidence(p, unit * std::sqrt(gx * gx + gy * gy), unit * std::sqrt(variance > 0 ? variance : 0.0f));
}

/** \brief Values of the slope-compensated form that are the same for all pixels of a view. */
struct SlopeScale {
  float straight;  ///< largest step between opposite neighbours per metre of depth, along rows and columns
  float diagonal;  ///< along diagonals
  float
      reference_noise_per_unit;  ///< ConfidenceParameters::noise at noise_reference, length units, over the view's noise scale
  NoiseModel noise;              ///< of the camera
};

/** \brief Computes SlopeScale::reference_noise_per_unit. \param p parameters  \param noise_scale as of slopeScale() */
FUSE_FLOW_HD float referenceNoisePerUnit(const ConfidenceParameters& p, float noise_scale) {
  return axialNoise(p.noise, p.noise_reference) / (p.length_unit * noise_scale);
}

/** \brief Computed once for each view. \param p parameters  \param pixel_angle tangent between neighbouring pixels, 1/f
 *  \param noise of the view: the same step can be noise for one sensor and an edge for another */
FUSE_FLOW_HD SlopeScale slopeScale(const ConfidenceParameters& p, float pixel_angle, const ViewNoise& noise) {
  const float step = 2.0f * std::tan(p.max_incidence) * pixel_angle;
  return {step, 1.41421356f * step, referenceNoisePerUnit(p, noise.scale), noise.model};
}

/** \brief Factor on the weight of a measurement by its noise: 1 / (1 + (σ / σ_½)²). This is inverse variance for noise well over σ_½, and
 *  nearly one for noise well under it. \param noise σ, metres \param per_half 1 / σ_½, 1/metres; 0: no such weight */
FUSE_FLOW_HD float noiseWeight(float noise, float per_half) {
  const float x = noise * per_half;
  return 1.0f / (1.0f + x * x);
}

/** \brief The largest axialNoise() that passes. \param max_noise of a measurement, metres; 0: any
 *  \param noise_scale noiseScale() of the view */
FUSE_FLOW_HD float noiseLimit(float max_noise, float noise_scale) {
  return max_noise > 0 ? max_noise / noise_scale : FLT_MAX;
}

/** \brief The conditions for a measurement to become a point, and its weight; the same for all pixels of a view. */
struct MeasurementGate {
  float threshold;   ///< C must be more than that, eq. 9
  float gate_noise;  ///< largest axialNoise() at which any C passes; negative: none
  float max_noise;   ///< see noiseLimit()
  float per_half;    ///< see noiseWeight()
  NoiseModel model;  ///< of the camera

  /** \brief Weight of a measurement; 0: it does not become a point. \param C of eq. 3  \param depth metres */
  FUSE_FLOW_HD float weight(float C, float depth) const {
    const float noise = axialNoise(model, depth);
    const float weight = C * noiseWeight(noise, per_half);
    const bool passes = ((C > threshold) | ((C > 0) & (noise <= gate_noise))) & !(noise > max_noise);
    return passes ? weight : 0.0f;
  }
};

/** \brief Once a view. \param threshold of C  \param gate_noise up to which C need not exceed it, metres; 0: it always must
 *  \param max_noise of a measurement, metres; 0: any
 *  \param half_weight_noise σ_½ of noiseWeight(), metres; 0: noise does not weigh  \param noise of the view */
FUSE_FLOW_HD MeasurementGate measurementGate(float threshold, float gate_noise, float max_noise,
                                             float half_weight_noise, const ViewNoise& noise) {
  return {threshold, gate_noise > 0 ? gate_noise / noise.scale : -1.0f, noiseLimit(max_noise, noise.scale),
          half_weight_noise > 0 ? noise.scale / half_weight_noise : 0.0f, noise.model};
}

/** \brief Number of the eight neighbouring measurements that also pass the gate and continue the surface. A neighbour continues the surface
 *  if it differs by at most the step of a surface seen at max_incidence plus three standard deviations of noise. \param slope of
 *  slopeScale()
 *  \param noise_scale noiseScale() of the view  \param depth D^r of eq. 8  \param weight of the same pixels, see MeasurementGate */
FUSE_FLOW_HD int surfaceSupport(const SlopeScale& slope, float noise_scale, const DepthPatch& depth,
                                const DepthPatch& weight) {
  const float centre = depth.z[4];
  const float noise = 3.0f * noise_scale * axialNoise(slope.noise, centre);
  const float straight = 0.5f * slope.straight * centre + noise;
  const float diagonal = 0.5f * slope.diagonal * centre + noise;
  int count = 0;
  for (int i = 0; i < 9; ++i) {
    if (i == 4) continue;
    const bool continues = std::fabs(depth.z[i] - centre) <= (i % 2 == 0 ? diagonal : straight);
    count += (weight.z[i] > 0) & continues;
  }
  return count;
}

/** \brief A sensor's own confidence in [0, 1]; NaN counts as none. */
FUSE_FLOW_HD float givenConfidence(float given) { return given > 0 ? (given < 1.0f ? given : 1.0f) : 0.0f; }

/** \brief Factor on the weight of a measurement by the sensor's own confidence, after the gate of eq. 9; 0: the measurement does not become
 *  a point.
 *  \param min_confidence see FuseFlowParameters */
FUSE_FLOW_HD float givenWeight(float given, float min_confidence) {
  const float confidence = givenConfidence(given);
  return confidence < min_confidence ? 0.0f : confidence;
}

/** \brief Slope-compensated form. Second differences r = z₋ − 2 z₀ + z₊ in the four directions through the pixel nearly
 *  vanish on a plane (depth is 1 / an affine function of the pixel there: r ≈ 2 s² / z for a step s between neighbours), and for
 *  independent noise they have the variance 6 σ². The amount by which the slope exceeds that of a surface at max_incidence is a jump. A
 *  direction with a missing neighbour counts as a quarter of a length unit in both terms, because sensors leave holes around bad
 *  measurements. */
FUSE_FLOW_HD float confidenceSlopeCompensated(const ConfidenceParameters& p, const DepthPatch& patch,
                                              const SlopeScale& slope) {
  const float* z = patch.z;
  const float centre = z[4];
  float pairs = 0, sum_squares = 0, excess = 0;
  const auto direction = [&](float a, float b, float max_slope) {
    const float valid = a > 0 ? (b > 0 ? 1.0f : 0.0f) : 0.0f;
    const float r = valid * (a - 2 * centre + b);
    const float over = valid * std::fabs(b - a) - max_slope * centre;
    pairs += valid;
    sum_squares += r * r;
    excess = over > excess ? over : excess;
  };
  direction(z[3], z[5], slope.straight);
  direction(z[1], z[7], slope.straight);
  direction(z[0], z[8], slope.diagonal);
  direction(z[2], z[6], slope.diagonal);
  const float scale = slope.reference_noise_per_unit / axialNoise(slope.noise, centre);
  const float missing = 1.0f - 0.25f * pairs;
  const float sigma = std::sqrt(sum_squares / (6.0f * (pairs > 1 ? pairs : 1.0f)));
  return confidence(p, 0.5f * excess * scale + missing, sigma * scale + missing);
}

}  // namespace fuse_flow
