#pragma once

#include <fuse_flow/gpu/select_points.h>

#if FUSE_FLOW_CUDA

namespace fuse_flow {
namespace gpu {

constexpr int kSelectThreads = 128;

/** \brief SelectPoints, one warp a cell. */
__global__ void __launch_bounds__(kSelectThreads) selectPointsKernel(const SelectPoints step) {
  const std::uint32_t rank = (blockIdx.x * kSelectThreads + threadIdx.x) / 32;
  if (rank >= step.cell_count) return;  // whole warps
  const std::uint32_t lane = threadIdx.x % 32;
  const std::uint32_t begin = step.cells[rank].begin;
  const std::uint32_t end = step.end(rank);
  const CoarseCell cell = step.children.cells[step.children.slotOf(begin)];
  bool open = true;
  while (open) {
    open = __any_sync(0xffffffffu, step.round(cell, begin, end, lane, 32));
    __syncwarp();
  }
}

}  // namespace gpu
}  // namespace fuse_flow

#endif
