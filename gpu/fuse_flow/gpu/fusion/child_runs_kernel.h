#pragma once

#include <fuse_flow/gpu/fusion/child_runs.h>

#if FUSE_FLOW_CUDA

namespace fuse_flow {
namespace gpu {

constexpr int kRunThreads = 256;

/** \brief Lanes that begin a run: their child is another than the one before. */
__device__ inline unsigned int runHeads(std::uint32_t child, unsigned int lane) {
  const std::uint32_t before = __shfl_up_sync(0xffffffffu, child, 1);
  return __ballot_sync(0xffffffffu, lane == 0 || child != before);
}

/** \brief CountRuns, one warp a chunk. */
static __global__ void __launch_bounds__(kRunThreads) countRunsKernel(const CountRuns step, std::uint32_t chunks) {
  const std::uint32_t index = blockIdx.x * kRunThreads + threadIdx.x;
  const std::uint32_t chunk = index / kChunk;
  if (chunk >= chunks) return;  // whole warps
  const unsigned int lane = threadIdx.x % kChunk;
  const std::uint32_t child = step.number(index);
  step.numbers[index] = child;
  const unsigned int heads = runHeads(child, lane);
  const unsigned int counted = heads & __ballot_sync(0xffffffffu, child != NumberChildren::kNone);
  if (lane == 0) step.runs[chunk] = static_cast<std::uint32_t>(__popc(counted));
}

/** \brief WriteRuns, one warp a chunk. */
static __global__ void __launch_bounds__(kRunThreads) writeRunsKernel(const WriteRuns step, std::uint32_t chunks) {
  const std::uint32_t index = blockIdx.x * kRunThreads + threadIdx.x;
  const std::uint32_t chunk = index / kChunk;
  if (chunk >= chunks) return;  // whole warps
  const unsigned int lane = threadIdx.x % kChunk;
  const std::uint32_t child = step.numbers[index];
  const unsigned int heads = runHeads(child, lane);
  const unsigned int counted = heads & __ballot_sync(0xffffffffu, child != NumberChildren::kNone);
  if (!(counted >> lane & 1u)) return;
  const unsigned int later = lane == 31 ? 0u : heads >> (lane + 1);
  const std::uint32_t count = later == 0 ? kChunk - lane : static_cast<std::uint32_t>(__ffs(later));
  const std::uint32_t place = step.places[chunk] + static_cast<std::uint32_t>(__popc(counted & ((1u << lane) - 1)));
  step.run_children[place] = child;
  step.runs[place] = ChildRun::pack(index, count);
}

}  // namespace gpu
}  // namespace fuse_flow

#endif
