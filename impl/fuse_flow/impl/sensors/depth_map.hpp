#pragma once

#include <fuse_flow/depth_view.h>
#include <fuse_flow/impl/host/wide_vectors.hpp>
#include <fuse_flow/math/confidence.h>
#include <fuse_flow/math/consistency.h>
#include <fuse_flow/math/depth.h>
#include <fuse_flow/math/depth_correction.h>
#include <fuse_flow/math/noise_scale.h>
#include <fuse_flow/math/pinhole.h>
#include <fuse_flow/math/smoothing.h>
#include <fuse_flow/sensors/depth_out_of_range.h>
#include <fuse_flow/sensors/preprocessing.h>

#include <cmath>
#include <limits>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief A depth image in metres, 0 where there is no measurement, with a border of zeros, so that neighbourhoods need no
 *  special case at the image's edge. */
class DepthMap {
 public:
  static constexpr int kBorder = kMaxSmoothingStep;
  static_assert(kBorder >= kNoiseSpacing, "second differences look that far");
  static_assert(kBorder >= kMaxSilhouetteRadius && kBorder >= kWideNormalSpacing, "so do silhouettes and normals");

  void resize(int width, int height) {
    if (width == width_ && height == height_) return;
    width_ = width;
    height_ = height;
    z_.assign(sizeOf(width, height), 0.0f);
  }
  /** \brief Room for images of a sizeOf(), so that resize() to one allocates nothing. */
  void reserve(std::size_t size) { z_.reserve(size); }
  /** \brief Values in memory, with the border. */
  static std::size_t sizeOf(int width, int height) {
    return static_cast<std::size_t>(width + 2 * kBorder) * static_cast<std::size_t>(height + 2 * kBorder);
  }
  void clear() { resize(0, 0); }

  int width() const { return width_; }
  int height() const { return height_; }
  int stride() const { return width_ + 2 * kBorder; }
  bool empty() const { return width_ == 0; }

  /** \brief Pointer to pixel (0, v). The border is kBorder pixels wide on all sides: v from −kBorder to height + kBorder
   *  − 1, and indices likewise. */
  float* row(int v) { return z_.data() + static_cast<std::ptrdiff_t>(v + kBorder) * stride() + kBorder; }
  const float* row(int v) const { return z_.data() + static_cast<std::ptrdiff_t>(v + kBorder) * stride() + kBorder; }

 private:
  int width_{0};
  int height_{0};
  std::vector<float> z_;
};

/** \brief Depths of the pixels around one. */
struct DepthsAround {
  const float* here;
  std::ptrdiff_t stride;

  DepthsAround(const DepthMap& map, int u, int v) : here(map.row(v) + u), stride(map.stride()) {}
  /** \param pixel counted from the map's first, as DepthMap::stride() has it */
  DepthsAround(const DepthMap& map, std::ptrdiff_t pixel) : here(map.row(0) + pixel), stride(map.stride()) {}

  FUSE_FLOW_HD float operator()(int a, int b) const { return here[b * stride + a]; }
};

/** \brief One row of a view in metres; what is outside [min_range, max_range] becomes 0. \param depth_scale of its camera
 *  \param terms of the row's pixels; null: none */
inline void convertDepthRow(const DepthView& view, float depth_scale, float min_range, float max_range, int v,
                            const DepthCorrectionTerms* terms, float* z) {
  inWideVectors([=, &view] {
    const int width = view.width();
    if (view.depth16) {
      const std::uint16_t* raw = view.depth16.row(v);
      const float scale = depth_scale;
      for (int u = 0; u < width; ++u) z[u] = metres(raw[u], scale, min_range, max_range);
    } else {
      const float* raw = view.depth32.row(v);
      for (int u = 0; u < width; ++u) z[u] = metres(raw[u], min_range, max_range);
    }
    if (terms == nullptr) return;
    const DepthCorrectionTerms* __restrict of_pixel = terms;
    float* __restrict corrected = z;
    for (int u = 0; u < width; ++u) corrected[u] = correctedDepth(corrected[u], of_pixel[u]);
  });
}

/** \brief What a view measures, in range or not. \param depth_scale of its camera  \param camera its number */
inline DepthOutOfRange depthOutOfRange(const DepthView& view, float depth_scale, std::size_t camera,
                                       const PreprocessingParameters& p) {
  DepthOutOfRange found;
  found.camera = camera;
  const auto see = [&](float z, bool in_range) {
    if (!(z > 0)) return;
    ++found.measured;
    found.in_range += in_range ? 1 : 0;
    found.nearest = found.measured == 1 || z < found.nearest ? z : found.nearest;
    found.farthest = z > found.farthest ? z : found.farthest;
  };
  constexpr float any = std::numeric_limits<float>::max();
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      if (view.depth16) {
        const std::uint16_t raw = view.depth16.row(v)[u];
        see(metres(raw, depth_scale, 0, any), metres(raw, depth_scale, p.min_range, p.max_range) > 0);
      } else {
        const float raw = view.depth32.row(v)[u];
        see(metres(raw, 0, any), metres(raw, p.min_range, p.max_range) > 0);
      }
  return found;
}

/** \brief Whether so few pixels of an image are measured in range that it is worth a look at the others. */
inline bool hardlyAny(std::size_t in_range, const Intrinsics& K) {
  return 50 * in_range < static_cast<std::size_t>(K.width) * static_cast<std::size_t>(K.height);
}

/** \brief Whether what is in range is the exception. */
inline bool nearlyAll(const DepthOutOfRange& found) { return found.measured > 10 * found.in_range; }

/** \brief The rows above, at and below one, at a spacing. */
struct RowsOfPatch {
  const float* __restrict above;
  const float* __restrict here;
  const float* __restrict below;
  int step;

  RowsOfPatch(const float* row_above, const float* row, const float* row_below)
      : above(row_above), here(row), below(row_below), step(1) {}
  RowsOfPatch(const DepthMap& depth, int v, int spacing)
      : above(depth.row(v - spacing)), here(depth.row(v)), below(depth.row(v + spacing)), step(spacing) {}

  DepthPatch operator[](int u) const {
    return {{above[u - step], above[u], above[u + step], here[u - step], here[u], here[u + step], below[u - step],
             below[u], below[u + step]}};
  }
};

/** \brief q = 1/z of one row; 0 where there is no measurement. */
inline void invertRow(const float* z, int width, float* q) {
  inWideVectors([=] {
    for (int u = 0; u < width; ++u) {
      const float inverse = 1.0f / z[u];
      q[u] = z[u] > 0 ? inverse : 0.0f;
    }
  });
}

/** \brief One pass of the smoothing over one row; holes stay holes. \param pass 0 … smoothingPasses() − 1  \param noise of the view
 *  \param q inverse depth, 1/metres  \param out inverse depth, or depth in metres after the last pass
 *  \param before_twicing inverse depth after smoothing.passes passes; read by twicing's last pass alone */
inline void smoothRow(const SmoothingParameters& smoothing, int pass, const ViewNoise& noise, const DepthMap& q, int v,
                      float* __restrict out, const DepthMap& before_twicing) {
  const float tolerance = smoothingTolerance(smoothing, pass, noise.scale);
  const RowsOfPatch rows(q, v, smoothingStep(smoothing, pass, noise.level()));
  const int width = q.width();
  const bool last = pass == smoothingPasses(smoothing) - 1, twices = last && pass >= smoothing.passes;
  const RowsOfPatch rows_before = twices ? RowsOfPatch(before_twicing, v, 1) : rows;
  inWideVectors([=, &noise, &smoothing] {
    const NoiseModel model = noise.model;  // copies: the compiler then knows that nothing overwrites them
    const RowsOfPatch patches = rows;
    float* __restrict smoothed_row = out;
    if (twices) {
      const SmoothingParameters p = smoothing;
      const float scale = noise.scale;
      const RowsOfPatch before = rows_before;
      for (int u = 0; u < width; ++u) {
        const float centre = patches.here[u];
        const float of_model = inverseDepthNoise(model, centre);
        const float again = smoothedInverseDepth(patches[u].z, tolerance * of_model);
        const float cross[5] = {before.here[u], before.here[u - 1], before.here[u + 1], before.above[u],
                                before.below[u]};
        const float twiced = twicedInverseDepth(p, cross, again, scale * of_model);
        smoothed_row[u] = centre > 0 ? twiced : 0.0f;
      }
      return;
    }
    for (int u = 0; u < width; ++u) {
      const float centre = patches.here[u];
      const float smoothed = smoothedInverseDepth(patches[u].z, tolerance * inverseDepthNoise(model, centre));
      smoothed_row[u] = centre > 0 ? smoothed : 0.0f;
    }
  });
  if (last) invertRow(out, width, out);
}

/** \brief Noise of a view over its camera's model: see noiseScale(). */
inline float measureNoiseScale(const NoiseModel& model, const DepthMap& depth) {
  std::uint32_t counts[kNoiseBins] = {};
  const auto count = [&](float before, float z, float after) {
    if (before > 0 && after > 0) ++counts[noiseBin(noiseRatio(model, before, z, after))];
  };
  for (int v = kNoiseStride / 2; v < depth.height(); v += kNoiseStride) {
    const float* here = depth.row(v);
    const float* above = depth.row(v - kNoiseSpacing);
    const float* below = depth.row(v + kNoiseSpacing);
    for (int u = kNoiseStride / 2; u < depth.width(); u += kNoiseStride) {
      if (!(here[u] > 0)) continue;
      count(here[u - kNoiseSpacing], here[u], here[u + kNoiseSpacing]);
      count(above[u], here[u], below[u]);
    }
  }
  return noiseScale(counts);
}

/** \brief Eq. 3 for one row of a depth map; C = 0 where there is no measurement. \param noise of the view */
inline void confidenceRow(const ConfidenceParameters& parameters, const DepthMap& depth, float pixel_angle,
                          const ViewNoise& noise, int v, float* __restrict C) {
  const SlopeScale slope_scale = slopeScale(parameters, pixel_angle, noise);
  inWideVectors([=, &depth, &parameters] {
    const ConfidenceParameters p = parameters;  // copies: the compiler then knows that C does not overwrite them
    const RowsOfPatch rows(depth, v, 1);
    const int width = depth.width();
    float* __restrict confidence_row = C;
    if (p.form == ConfidenceForm::Published) {
      for (int u = 0; u < width; ++u) {
        const float c = confidencePublished(p, rows[u]);
        confidence_row[u] = rows.here[u] > 0 ? c : 0.0f;
      }
    } else {
      const SlopeScale slope = slope_scale;
      for (int u = 0; u < width; ++u) {
        const float c = confidenceSlopeCompensated(p, rows[u], slope);
        confidence_row[u] = rows.here[u] > 0 ? c : 0.0f;
      }
    }
  });
}

}  // namespace host
}  // namespace fuse_flow
