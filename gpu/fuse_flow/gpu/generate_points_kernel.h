#pragma once

#include <fuse_flow/gpu/generate_points.h>

#if FUSE_FLOW_CUDA

namespace fuse_flow {
namespace gpu {

constexpr int kGenerateThreads = 256;

/** \brief GeneratePoints, one warp a chunk: neighbouring pixels nearly always share a cell, so that the table is asked once a run,
 *  not once a point. */
static __global__ void __launch_bounds__(kGenerateThreads)
    generatePointsKernel(const GeneratePoints step, std::uint32_t chunks) {
  constexpr unsigned int all = 0xffffffffu;
  const unsigned int lane = threadIdx.x % kChunk;
  const std::uint32_t warps = gridDim.x * (kGenerateThreads / kChunk);
  std::uint32_t measured_points = 0, gated_points = 0;  // of the warp
  for (std::uint32_t chunk = (blockIdx.x * kGenerateThreads + threadIdx.x) / kChunk; chunk < chunks; chunk += warps) {
    const std::uint32_t index = chunk * kChunk + lane;
    const PixelAddress a = step.grid.addressOf(chunk * kChunk);
    bool measured = false;
    const WeightedPoint point = step.measure(step.grid.views[a.view], a.u + static_cast<int>(lane), a.v, measured);
    step.points[index] = point;
    measured_points += __popc(__ballot_sync(all, measured));
    gated_points += __popc(__ballot_sync(all, point.C > 0));
    if (!step.use_cells) continue;
    const std::uint64_t key = step.keyOf(point, index);
    const std::uint64_t before = __shfl_up_sync(all, key, 1);
    const bool head = lane == 0 || key != before;
    const unsigned int heads = __ballot_sync(all, head);
    std::uint32_t slot = CellTableView::kNone;
    if (head && key != CellTableView::kEmpty) {
      slot = step.table.findOrAdd(key);
      const unsigned int later = lane == 31 ? 0u : heads >> (lane + 1);
      step.table.addPoints(slot, index, later == 0 ? kChunk - lane : static_cast<unsigned int>(__ffs(later)));
    }
    const unsigned int upto = heads & (all >> (31 - lane));
    step.slots[index] = __shfl_sync(all, slot, 31 - __clz(upto));
  }
  __shared__ std::uint32_t sums[2];
  if (threadIdx.x < 2) sums[threadIdx.x] = 0;
  __syncthreads();
  if (lane == 0) {
    atomicAdd(&sums[0], measured_points);
    atomicAdd(&sums[1], gated_points);
  }
  __syncthreads();
  if (threadIdx.x == 0) {
    atomicAdd(&step.counts->measured, sums[0]);
    atomicAdd(&step.counts->gated, sums[1]);
  }
}

}  // namespace gpu
}  // namespace fuse_flow

#endif
