#pragma once

#include <fuse_flow/calibration/extrinsic_parameters.h>
#include <fuse_flow/fusion/parameters.h>
#include <fuse_flow/rig_frame.h>

#include <cstdint>
#include <cstring>
#include <type_traits>

namespace fuse_flow {
namespace distributed {

/** \brief A number that differs where parameters, or rigs, differ (FNV-1a, 64 bits). Every part is taken apart by name, so that one that
 *  is added later does not compile until it is here. */
class FrameDigest {
 public:
  FrameDigest& add(const FuseFlowParameters& p) {
    const auto& [preprocessing, smoothing, confidence, consistency, aggregation, adapt_noise, half_weight_noise,
                 gate_noise, max_noise, min_support, min_confidence, agreement, use_confidence, use_consistency,
                 use_hash, crop_box] = p;
    add(preprocessing).add(smoothing).add(confidence).add(consistency).add(aggregation);
    addAll(adapt_noise, half_weight_noise, gate_noise, max_noise, min_support, min_confidence, use_confidence,
           use_consistency, use_hash, crop_box.has_value());
    add(agreement);
    if (crop_box)
      for (int k = 0; k < 3; ++k) addAll(crop_box->min()[k], crop_box->max()[k]);
    return *this;
  }

  FrameDigest& add(const ExtrinsicParameters& p) {
    const auto& [preprocessing, smoothing, max_speckle, noise, reduction, coarse_above, samples, max_neighbours,
                 max_distance, min_distance, max_angle, min_information, residual_multipath, use_color, max_iterations,
                 gauge] = p;
    add(preprocessing).add(smoothing).add(noise);
    return addAll(max_speckle, reduction, coarse_above, samples, max_neighbours, max_distance, min_distance, max_angle,
                  min_information, residual_multipath, use_color, max_iterations, gauge);
  }

  /** \brief Of the calibration; not of the images. */
  FrameDigest& add(const std::vector<Camera>& cameras) {
    for (const Camera& camera : cameras) add(camera);
    return *this;
  }

  /** \brief Numbers and enumerators. */
  template <typename... T>
  FrameDigest& addAll(const T&... values) {
    (addBytes(values), ...);
    return *this;
  }

  std::uint64_t value() const { return value_; }

 private:
  FrameDigest& add(const PreprocessingParameters& p) {
    const auto& [min_range, max_range, fill_neighbours, fill_tolerance, bilateral, sigma_s, sigma_r] = p;
    return addAll(min_range, max_range, fill_neighbours, fill_tolerance, bilateral, sigma_s, sigma_r);
  }
  FrameDigest& add(const SmoothingParameters& p) {
    const auto& [passes, tolerance, shrink, wide_above, twicing, twicing_above] = p;
    return addAll(passes, tolerance, shrink, wide_above, twicing, twicing_above);
  }
  FrameDigest& add(const NoiseModel& model) {
    const auto& [floor, linear, quadratic] = model;
    return addAll(floor, linear, quadratic);
  }
  FrameDigest& add(const ConfidenceParameters& p) {
    const auto& [form, alpha, beta, gamma, delta, threshold, length_unit, noise, noise_reference, max_incidence] = p;
    return addAll(form, alpha, beta, gamma, delta, threshold, length_unit, noise_reference, max_incidence).add(noise);
  }
  FrameDigest& add(const ConsistencyParameters& p) {
    const auto& [occlusion, distance, sigma, sigma_per_noise, margin, penalty, weigh, min_facing, radius, max_views,
                 max_candidates] = p;
    return addAll(occlusion, distance, sigma, sigma_per_noise, margin, penalty, weigh, min_facing, radius, max_views,
                  max_candidates);
  }
  FrameDigest& add(const AggregationParameters& p) {
    const auto& [cell_size, min_cell_size, points_per_cell, representatives, at, min_weight, weak_weight, reach,
                 reach_per_noise] = p;
    return addAll(cell_size, min_cell_size, points_per_cell, representatives, at, min_weight, weak_weight, reach,
                  reach_per_noise);
  }
  FrameDigest& add(const AgreementParameters& p) {
    const auto& [min_views, pixels, relative] = p;
    return addAll(min_views, pixels, relative);
  }
  FrameDigest& add(const Intrinsics& K) {
    const auto& [width, height, fx, fy, cx, cy, distortion] = K;
    const auto& [k1, k2, p1, p2, k3, k4, k5, k6] = distortion;
    return addAll(width, height, fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, k5, k6);
  }
  FrameDigest& add(const Eigen::Isometry3d& T) {
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 4; ++column) addAll(T.matrix()(row, column));
    return *this;
  }
  FrameDigest& add(const Camera& camera) {
    const auto& [name, intrinsics, depth_scale, pose, color, correction, multipath, noise] = camera;
    addAll(name.size(), depth_scale, color.has_value(), noise.has_value());
    for (const char c : name) addAll(c);
    add(intrinsics).add(pose);
    if (color) add(color->intrinsics).add(color->T_depth_color);
    const auto& [columns, rows, relative, per_metre] = correction;
    addAll(columns, rows);
    for (const float value : relative) addAll(value);
    for (const float value : per_metre) addAll(value);
    const auto& [frequency, reflectance] = multipath;
    addAll(frequency, reflectance);
    return noise ? add(*noise) : *this;
  }

  template <typename T>
  void addBytes(const T& value) {
    static_assert(std::is_arithmetic<T>::value || std::is_enum<T>::value, "what has padding has no bytes of its own");
    unsigned char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    for (const unsigned char byte : bytes) value_ = (value_ ^ byte) * 0x100000001b3ull;
  }

  std::uint64_t value_{0xcbf29ce484222325ull};
};

}  // namespace distributed
}  // namespace fuse_flow
