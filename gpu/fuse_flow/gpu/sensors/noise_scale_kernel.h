#pragma once

#include <fuse_flow/gpu/sensors/noise_scale.h>

#if FUSE_FLOW_CUDA

namespace fuse_flow {
namespace gpu {

constexpr int kNoiseThreads = kNoiseBins;
/** \brief Blocks that share a view's rows. */
constexpr unsigned int kNoiseBlocks = 24;

/** \brief CountNoise: block (x, y) counts every kNoiseBlocks-th looked-at row of view y. */
static __global__ void __launch_bounds__(kNoiseThreads) countNoiseKernel(const CountNoise step) {
  __shared__ std::uint32_t bins[kNoiseBins];
  const DeviceView& view = step.grid.views[blockIdx.y];
  if (!view.present) return;  // whole blocks
  bins[threadIdx.x] = 0;
  __syncthreads();
  const int columns = (view.model.intrinsics.width + kNoiseStride - 1) / kNoiseStride;
  const int rows = (view.model.intrinsics.height + kNoiseStride - 1) / kNoiseStride;
  for (int row = static_cast<int>(blockIdx.x); row < rows; row += kNoiseBlocks)
    for (int column = static_cast<int>(threadIdx.x); column < columns; column += kNoiseThreads)
      step.forEachBin(view, column * kNoiseStride + kNoiseStride / 2, row * kNoiseStride + kNoiseStride / 2,
                      [](int bin) { atomicAdd(&bins[bin], 1u); });
  __syncthreads();
  if (bins[threadIdx.x] > 0) atomicAdd(step.counts + blockIdx.y * kNoiseBins + threadIdx.x, bins[threadIdx.x]);
}

/** \brief MeasureNoise, one block a view: the bin of the median is the one whose thread finds it. */
static __global__ void __launch_bounds__(kNoiseThreads) measureNoiseKernel(const MeasureNoise step) {
  __shared__ std::uint32_t sums[kNoiseBins];
  const int bin = static_cast<int>(threadIdx.x);
  const std::uint32_t count = step.counts[blockIdx.x * kNoiseBins + threadIdx.x];
  sums[bin] = count;
  __syncthreads();
  for (int distance = 1; distance < kNoiseBins; distance *= 2) {
    const std::uint32_t before = bin >= distance ? sums[bin - distance] : 0u;
    __syncthreads();
    sums[bin] += before;
    __syncthreads();
  }
  const std::uint32_t total = sums[kNoiseBins - 1], upto = sums[bin], before = upto - count;
  const float half = 0.5f * static_cast<float>(total);
  if (total < kMinNoiseSamples) {
    if (bin == 0) step.result.set(blockIdx.x, 1.0f);
    return;
  }
  const bool all_before_are_short = bin == 0 || static_cast<float>(before) < half;
  if (all_before_are_short && (static_cast<float>(upto) >= half || bin == kNoiseBins - 1))
    step.result.set(blockIdx.x, noiseScaleInBin(bin, half, before, count));
}

}  // namespace gpu
}  // namespace fuse_flow

#endif
