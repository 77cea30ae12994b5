#pragma once

#include <fuse_flow/gpu/calibration/choose_samples.h>

#if FUSE_FLOW_CUDA

namespace fuse_flow {
namespace gpu {

constexpr unsigned int kMomentThreads = 256;

/** \brief SumMoments, one block a view. */
static __global__ void __launch_bounds__(kMomentThreads) sumMomentsKernel(const SumMoments step) {
  __shared__ PointMoments parts[kMomentThreads];
  parts[threadIdx.x] = step.every(blockIdx.x, threadIdx.x, kMomentThreads);
  __syncthreads();
  for (unsigned int half = kMomentThreads / 2; half > 0; half /= 2) {
    if (threadIdx.x < half) parts[threadIdx.x].add(parts[threadIdx.x + half]);
    __syncthreads();
  }
  if (threadIdx.x == 0) step.moments[blockIdx.x] = parts[0];
}

}  // namespace gpu
}  // namespace fuse_flow

#endif
