#pragma once

#include <fuse_flow/impl/camera.hpp>
#include <fuse_flow/math/adaptive_hash.h>
#include <fuse_flow/math/confidence.h>
#include <fuse_flow/math/consistency.h>
#include <fuse_flow/math/smoothing.h>
#include <fuse_flow/sensors/preprocessing.h>

#include <algorithm>

namespace fuse_flow {
namespace detail {

/** \brief Throws unless the value lies in [low, high]; NaN never does. */
template <typename Value>
void checkRange(const char* owner, const char* name, Value value, Value low, Value high) {
  if (!(value >= low && value <= high))
    throwBadArgument(owner, ": ", name, " is ", value, ", must be in [", low, ", ", high, "]");
}

inline void checkPositive(const char* owner, const char* name, float value) {
  if (!(value > 0 && std::isfinite(value))) throwBadArgument(owner, ": ", name, " is ", value, ", must be positive");
}

inline void checkNonNegative(const char* owner, const char* name, float value) {
  if (!(value >= 0 && std::isfinite(value)))
    throwBadArgument(owner, ": ", name, " is ", value, ", must not be negative");
}

/** \brief Far more than any distance that decides about a surface has: who says more means another unit. */
constexpr float kLongest = 10;

/** \brief Throws for a length that is too large, with its unit. */
inline void checkUpTo(const char* owner, const char* name, float metres, float longest) {
  if (metres <= longest) return;
  throwBadArgument(owner, ": ", name, " is ", metres, " m, must be ", longest, " m or less; ", metres, " mm are ",
                   metres / 1000, " m");
}

/** \brief Of a length in metres; (0, longest]. */
inline void checkLength(const char* owner, const char* name, float metres, float longest = kLongest) {
  checkPositive(owner, name, metres);
  checkUpTo(owner, name, metres, longest);
}

/** \brief Of a length in metres; [0, kLongest]. */
inline void checkLengthOrNone(const char* owner, const char* name, float metres) {
  checkNonNegative(owner, name, metres);
  checkUpTo(owner, name, metres, kLongest);
}

/** \brief Of depth that counts as a measurement. */
inline void checkMeasuringRange(const char* owner, float min_range, float max_range) {
  checkNonNegative(owner, "min_range", min_range);
  checkPositive(owner, "max_range", max_range);
  if (max_range <= min_range)
    throwBadArgument(owner, ": max_range is ", max_range, ", must exceed min_range, ", min_range);
}

/** \brief Whether fused points move to where refined depth confirms them. */
inline bool usesConfirmation(const SmoothingParameters& smoothing, const AggregationParameters& aggregation) {
  return smoothing.passes > 0 && aggregation.confirmation_reach > 0 &&
         aggregation.consistency_at == ConsistencyAt::CellMean;
}

}  // namespace detail

inline void checkParameters(const PreprocessingParameters& p) {
  constexpr const char* owner = "fuse_flow::DepthBackprojection";
  detail::checkMeasuringRange(owner, p.min_range, p.max_range);
  if (p.fill_neighbours != 0) detail::checkRange(owner, "fill_neighbours", p.fill_neighbours, 3, 8);
  detail::checkLength(owner, "fill_tolerance", p.fill_tolerance);
  detail::checkPositive(owner, "bilateral_sigma_s", p.bilateral_sigma_s);
  detail::checkLength(owner, "bilateral_sigma_r", p.bilateral_sigma_r);
}

inline void checkParameters(const SmoothingParameters& p) {
  constexpr const char* owner = "fuse_flow::FuseFlow";
  detail::checkRange(owner, "smoothing_passes", p.passes, 0, kMaxSmoothingPasses);
  detail::checkPositive(owner, "smoothing_tolerance", p.tolerance);
  detail::checkPositive(owner, "smoothing_shrink", p.shrink);
  detail::checkRange(owner, "smoothing_shrink", p.shrink, 0.0f, 1.0f);
  detail::checkNonNegative(owner, "smoothing_wide_above", p.wide_above);
  detail::checkNonNegative(owner, "smoothing_twicing_above", p.twicing_above);
}

namespace detail {

/** \brief Throws for a model without noise at any depth, and for a model that is not finite. */
inline void checkNoise(const char* owner, const NoiseModel& noise) {
  checkLengthOrNone(owner, "noise.floor", noise.floor);
  checkNonNegative(owner, "noise.linear", noise.linear);
  checkRange(owner, "noise.linear", noise.linear, 0.0f, 10.0f);
  checkNonNegative(owner, "noise.quadratic", noise.quadratic);
  checkRange(owner, "noise.quadratic", noise.quadratic, 0.0f, 10.0f);
  checkPositive(owner, "noise.floor + noise.linear + noise.quadratic", noise.floor + noise.linear + noise.quadratic);
}

}  // namespace detail

inline void checkParameters(const ConfidenceParameters& p) {
  constexpr const char* owner = "fuse_flow::ConfidenceEstimation";
  detail::checkNonNegative(owner, "alpha", p.alpha);
  detail::checkNonNegative(owner, "beta", p.beta);
  detail::checkNonNegative(owner, "gamma", p.gamma);
  detail::checkNonNegative(owner, "delta", p.delta);
  detail::checkPositive(owner, "alpha + gamma", p.alpha + p.gamma);
  detail::checkRange(owner, "threshold", p.threshold, 0.0f, 1.0f);
  detail::checkLength(owner, "length_unit", p.length_unit);
  detail::checkNoise(owner, p.noise);
  detail::checkLength(owner, "noise_reference", p.noise_reference, 1000);
  detail::checkRange(owner, "max_incidence", p.max_incidence, 0.01f, 1.57f);
}

inline void checkParameters(const ConsistencyParameters& p) {
  constexpr const char* owner = "fuse_flow::MultiViewConsistency";
  detail::checkLength(owner, "sigma", p.sigma);
  detail::checkNonNegative(owner, "sigma_per_noise", p.sigma_per_noise);
  detail::checkPositive(owner, "margin", p.margin);
  detail::checkPositive(owner, "free_space_penalty", p.free_space_penalty);
  detail::checkRange(owner, "free_space_penalty", p.free_space_penalty, 0.0f, 1.0f);
  detail::checkRange(owner, "min_facing", p.min_facing, -1.0f, 1.0f);
  detail::checkRange(owner, "silhouette_radius", p.silhouette_radius, 0, kMaxSilhouetteRadius);
  detail::checkRange(owner, "max_views", p.max_views, 2, 1 << 16);
  detail::checkRange(owner, "max_candidates", p.max_candidates, p.max_views - 1, 1 << 16);
}

inline void checkParameters(const AggregationParameters& p) {
  constexpr const char* owner = "fuse_flow::AdaptiveHashFusion";
  detail::checkLength(owner, "cell_size", p.cell_size);
  detail::checkLength(owner, "min_cell_size", p.min_cell_size, std::max(1.0f, p.cell_size));
  detail::checkPositive(owner, "points_per_cell", p.points_per_cell);
  detail::checkRange(owner, "min_weight", p.min_weight, 0.0f, 1.0f);
  detail::checkRange(owner, "weak_weight", p.weak_weight, 0.0f, 1.0f);
  detail::checkLengthOrNone(owner, "confirmation_reach", p.confirmation_reach);
  detail::checkNonNegative(owner, "reach_per_noise", p.reach_per_noise);
}

}  // namespace fuse_flow
