#pragma once

#include <fuse_flow/gpu/sensors/device_view.h>
#include <fuse_flow/math/noise_scale.h>

namespace fuse_flow {
namespace gpu {

/** \brief The second differences of each view's inverse depth, counted in its histogram. As a step of forEach() it works on one
 *  chunk of pixels; the CUDA kernel counts in shared memory first. */
struct CountNoise {
  PixelGrid grid;
  const float* z;
  std::uint32_t* counts;  // kNoiseBins of each view

  /** \brief Calls count(bin) for the two second differences at a pixel, where they exist. */
  template <typename Count>
  FUSE_FLOW_HD void forEachBin(const DeviceView& view, int u, int v, const Count& count) const {
    const DepthMapOfView map{&view, z};
    const float here = map.depth(u, v);
    if (!(here > 0)) return;
    const float left = map.depth(u - kNoiseSpacing, v), right = map.depth(u + kNoiseSpacing, v);
    const float above = map.depth(u, v - kNoiseSpacing), below = map.depth(u, v + kNoiseSpacing);
    if (left > 0 && right > 0) count(noiseBin(noiseRatio(view.noise.model, left, here, right)));
    if (above > 0 && below > 0) count(noiseBin(noiseRatio(view.noise.model, above, here, below)));
  }

  FUSE_FLOW_HD void operator()(std::uint32_t chunk) const {
    const PixelAddress a = grid.addressOf(chunk * kChunk);
    if (!grid.views[a.view].present || a.v % kNoiseStride != kNoiseStride / 2) return;
    std::uint32_t* own = counts + a.view * kNoiseBins;
    for (int u = a.u + kNoiseStride / 2; u < a.u + static_cast<int>(kChunk); u += kNoiseStride)
      forEachBin(grid.views[a.view], u, a.v, [own](int bin) { atomicAddTo(own + bin, 1u); });
  }
};

/** \brief What depends on a view's noise, once that is known. */
struct SetNoiseScale {
  ConfidenceParameters parameters;
  DeviceView* views;
  float* scales;

  FUSE_FLOW_HD void set(std::uint32_t i, float scale) const {
    scales[i] = scale;
    views[i].noise.scale = scale;
    views[i].slope.reference_noise_per_unit = referenceNoisePerUnit(parameters, scale);
  }
};

/** \brief One view. */
struct MeasureNoise {
  SetNoiseScale result;
  const std::uint32_t* counts;

  FUSE_FLOW_HD void operator()(std::uint32_t i) const { result.set(i, noiseScale(counts + i * kNoiseBins)); }
};

}  // namespace gpu
}  // namespace fuse_flow
