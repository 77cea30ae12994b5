#pragma once

#include <fuse_flow/depth_view.h>
#include <fuse_flow/math/confidence.h>
#include <fuse_flow/math/depth.h>

#include <cmath>
#include <limits>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief A depth image in metres, 0 where there is no measurement, with a border of one pixel of zeros, so that 3×3
 *  neighbourhoods need no special case at the image's edge. */
class DepthMap {
 public:
  void resize(int width, int height) {
    if (width == width_ && height == height_) return;
    width_ = width;
    height_ = height;
    z_.assign(static_cast<std::size_t>(stride()) * static_cast<std::size_t>(height + 2), 0.0f);
  }
  void clear() { resize(0, 0); }

  int width() const { return width_; }
  int height() const { return height_; }
  int stride() const { return width_ + 2; }
  bool empty() const { return width_ == 0; }

  /** \brief Pointer to pixel (0, v); indices −1 and width are the border. v from −1 to height. */
  float* row(int v) { return z_.data() + static_cast<std::ptrdiff_t>(v + 1) * stride() + 1; }
  const float* row(int v) const { return z_.data() + static_cast<std::ptrdiff_t>(v + 1) * stride() + 1; }

 private:
  int width_{0};
  int height_{0};
  std::vector<float> z_;
};

/** \brief One row of a view in metres; what is outside [min_range, max_range] becomes 0. */
inline void convertDepthRow(const DepthView& view, float min_range, float max_range, int v, float* z) {
  const int width = view.width();
  if (view.depth16) {
    const std::uint16_t* raw = view.depth16.row(v);
    const float scale = view.depth_scale;
    for (int u = 0; u < width; ++u) z[u] = metres(raw[u], scale, min_range, max_range);
  } else {
    const float* raw = view.depth32.row(v);
    for (int u = 0; u < width; ++u) z[u] = metres(raw[u], min_range, max_range);
  }
}

/** \brief Eq. 3 for one row of a depth map; C = 0 where there is no measurement. */
inline void confidenceRow(const ConfidenceParameters& parameters, const DepthMap& depth, float pixel_angle, int v,
                          float* __restrict C) {
  const ConfidenceParameters p = parameters;  // a copy: the compiler then knows that C does not overwrite it
  const float* __restrict above = depth.row(v - 1);
  const float* __restrict here = depth.row(v);
  const float* __restrict below = depth.row(v + 1);
  const int width = depth.width();
  if (p.form == ConfidenceForm::Published) {
    for (int u = 0; u < width; ++u) {
      const DepthPatch patch{{above[u - 1], above[u], above[u + 1], here[u - 1], here[u], here[u + 1], below[u - 1],
                              below[u], below[u + 1]}};
      const float c = confidencePublished(p, patch);
      C[u] = here[u] > 0 ? c : 0.0f;
    }
  } else {
    const SlopeScale slope = slopeScale(p, pixel_angle);
    for (int u = 0; u < width; ++u) {
      const DepthPatch patch{{above[u - 1], above[u], above[u + 1], here[u - 1], here[u], here[u + 1], below[u - 1],
                              below[u], below[u + 1]}};
      const float c = confidenceSlopeCompensated(p, patch, slope);
      C[u] = here[u] > 0 ? c : 0.0f;
    }
  }
}

}  // namespace host
}  // namespace fuse_flow
