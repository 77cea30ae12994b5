#pragma once

#include <fuse_flow/gpu/fusion/fuse_children.h>

#if FUSE_FLOW_CUDA

namespace fuse_flow {
namespace gpu {

constexpr int kFuseThreads = 256;
constexpr std::uint32_t kChildrenOfBlock = 1024;

/** \brief FuseChildren, sorted within each block by the number of runs. Half of the children hold a single point and some
 *  hundreds: in their own order the lanes of a warp would wait for the longest. Each child writes to its own place, so that the
 *  order within a block, which differs from run to run, shows nowhere. */
static __global__ void __launch_bounds__(kFuseThreads, 3) fuseChildrenKernel(const FuseChildren step) {
  constexpr std::uint32_t bins = 32;
  __shared__ std::uint32_t places[bins];
  __shared__ std::uint16_t order[kChildrenOfBlock];
  const Children& children = step.select.children;
  const std::uint32_t first = blockIdx.x * kChildrenOfBlock;
  const std::uint32_t count = *children.count;
  if (first >= count) return;  // whole blocks
  const std::uint32_t n = count - first < kChildrenOfBlock ? count - first : kChildrenOfBlock;
  const auto binOf = [&children, first](std::uint32_t k) {  // the longest first
    const std::uint32_t runs = children.end(first + k) - children.begins[first + k];
    return runs < bins ? bins - runs : 0u;
  };

  if (threadIdx.x < bins) places[threadIdx.x] = 0;
  __syncthreads();
  for (std::uint32_t k = threadIdx.x; k < n; k += kFuseThreads) atomicAdd(&places[binOf(k)], 1u);
  __syncthreads();
  if (threadIdx.x < bins) {
    const std::uint32_t own = places[threadIdx.x];
    std::uint32_t upto = own;
    for (unsigned int step_size = 1; step_size < bins; step_size *= 2) {
      const std::uint32_t before = __shfl_up_sync(0xffffffffu, upto, step_size);
      upto += threadIdx.x >= step_size ? before : 0u;
    }
    places[threadIdx.x] = upto - own;
  }
  __syncthreads();
  for (std::uint32_t k = threadIdx.x; k < n; k += kFuseThreads)
    order[atomicAdd(&places[binOf(k)], 1u)] = static_cast<std::uint16_t>(k);
  __syncthreads();
  for (std::uint32_t k = threadIdx.x; k < n; k += kFuseThreads) step(first + order[k]);
}

/** \brief \param most at least as many as there are children, whose number only the device knows */
inline void fuseChildrenInBlocks(const FuseChildren& step, std::size_t most, cudaStream_t stream) {
  const std::size_t blocks = (most + kChildrenOfBlock - 1) / kChildrenOfBlock;
  fuseChildrenKernel<<<static_cast<unsigned int>(blocks), kFuseThreads, 0, stream>>>(step);
  check(cudaGetLastError(), "fuseChildrenKernel");
}

}  // namespace gpu
}  // namespace fuse_flow

#endif
