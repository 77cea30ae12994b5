#pragma once

#include <fuse_flow/gpu/calibration/normal_noise.h>

#if FUSE_FLOW_CUDA

namespace fuse_flow {
namespace gpu {

/** \brief MeasureNormalNoise, one block a view. */
static __global__ void __launch_bounds__(1024) measureNormalNoiseKernel(const MeasureNormalNoise step) {
  constexpr std::uint32_t kBins = MeasureNormalNoise::kBins;
  __shared__ std::uint32_t counts[kBins], upto[kBins];
  __shared__ std::uint32_t known, rank;
  const DeviceView& view = step.grid.views[blockIdx.x];
  const std::uint32_t pairs = step.pairs(view), bin = threadIdx.x;
  std::uint32_t total = 0;
  if (threadIdx.x == 0) known = rank = 0;
  for (int round = 0; round < MeasureNormalNoise::kRounds; ++round) {
    if (bin < kBins) counts[bin] = 0;
    __syncthreads();
    for (std::uint32_t pair = threadIdx.x; pair < pairs; pair += blockDim.x) {
      std::uint32_t bits = 0;
      if (step.sine(view, pair, bits) && MeasureNormalNoise::begins(bits, known, round))
        atomicAdd(&counts[MeasureNormalNoise::binOf(bits, round)], 1u);
    }
    __syncthreads();
    if (bin < kBins) upto[bin] = counts[bin];
    __syncthreads();
    for (std::uint32_t distance = 1; distance < kBins; distance *= 2) {
      const std::uint32_t before = bin < kBins && bin >= distance ? upto[bin - distance] : 0u;
      __syncthreads();
      if (bin < kBins) upto[bin] += before;
      __syncthreads();
    }
    if (round == 0) total = upto[kBins - 1];
    if (total == 0) break;  // all threads alike
    const std::uint32_t wanted = round == 0 ? total / 2 : rank;
    const std::uint32_t known_before = round == 0 ? 0u : known;
    __syncthreads();  // all have read
    if (bin < kBins && wanted >= upto[bin] - counts[bin] && wanted < upto[bin]) {
      known = known_before << 8 | bin;
      rank = wanted - (upto[bin] - counts[bin]);
    }
    __syncthreads();
  }
  if (threadIdx.x == 0) step.set(blockIdx.x, total, total > 0 ? known : 0u);
}

}  // namespace gpu
}  // namespace fuse_flow

#endif
