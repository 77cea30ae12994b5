#pragma once

#include <fuse_flow/impl/host/wide_vectors.hpp>
#include <fuse_flow/impl/sensors/depth_map.hpp>
#include <fuse_flow/math/confidence.h>

#include <algorithm>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief What the measurements of three neighbouring rows of a view weigh, to see which of the middle one's are supported. One a
 *  thread, with the memory it keeps. */
class WeightRows {
 public:
  /** \brief Rows are at most so wide from now on. */
  void reserve(std::size_t width) {
    for (std::vector<float>& row : rows_)
      if (row.size() < width + 2) row.resize(width + 2);
  }

  /** \brief Begins a view. */
  void start(int width) {
    width_ = width;
    for (std::vector<float>& row : rows_) row[0] = row[static_cast<std::size_t>(width) + 1] = 0;
  }

  /** \brief Row v from its first pixel on, to be filled in; it takes the place of row v − 3. */
  float* row(int v) { return rows_[static_cast<std::size_t>(v + 3) % 3].data() + 1; }
  /** \brief Row v is beyond the image. */
  void clear(int v) { std::fill_n(row(v), width_, 0.0f); }

  /** \brief The weights of row v, 0 where there is too little support; rows v − 1 to v + 1 must be filled in. \param depth D^r
   *  \param noise_scale of the view */
  void keepSupported(const SlopeScale& slope_scale, float noise_scale, int min_support, const DepthMap& depth, int v,
                     float* supported) {
    inWideVectors([&, this] {
      const SlopeScale slope = slope_scale;  // copies: the compiler then knows that nothing overwrites them
      const RowsOfPatch depths(depth, v, 1), weights(row(v - 1), row(v), row(v + 1));
      const float scale = noise_scale;
      const int width = width_, needed = min_support;
      float* __restrict out = supported;
      for (int u = 0; u < width; ++u) {
        const int support = surfaceSupport(slope, scale, depths[u], weights[u]);
        out[u] = support >= needed ? weights.here[u] : 0.0f;
      }
    });
  }

 private:
  int width_{0};
  std::vector<float> rows_[3];  ///< with a zero at each end
};

}  // namespace host
}  // namespace fuse_flow
