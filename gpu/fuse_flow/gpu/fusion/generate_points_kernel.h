#pragma once

#include <fuse_flow/gpu/fusion/generate_points.h>
#include <fuse_flow/gpu/sensors/tiles.h>

#if FUSE_FLOW_CUDA

namespace fuse_flow {
namespace gpu {

/** \brief The slot of a point's place. Neighbouring pixels nearly always share a cell: the first lane of each run asks
 *  the table for all of it. Whole warps, whose points of one place ascend. */
template <typename Places>
__device__ std::uint32_t slotOfWarp(const Places& places, std::uint64_t key, std::uint32_t view, std::uint32_t index) {
  constexpr unsigned int all = 0xffffffffu;
  const unsigned int lane = threadIdx.x % kChunk;
  const std::uint64_t before = __shfl_up_sync(all, key, 1);
  const bool head = lane == 0 || key != before;
  const unsigned int heads = __ballot_sync(all, head);
  std::uint32_t slot = CellTableView::kNone;
  if (head && key != CellTableView::kEmpty) {
    slot = places.table.findOrAdd(key);
    const unsigned int later = lane == 31 ? 0u : heads >> (lane + 1);
    places.addPoints(slot, view, index, later == 0 ? kChunk - lane : static_cast<unsigned int>(__ffs(later)));
  }
  const unsigned int upto = heads & (all >> (31 - lane));
  return __shfl_sync(all, slot, 31 - __clz(upto));
}

/** \brief WeighMeasurements, one block a tile. */
static __global__ void __launch_bounds__(kTileThreads)
    weighMeasurementsKernel(const WeighMeasurements step, const TileGrid tiles) {
  forEachPixelOfTile(tiles, [&step](const PixelAddress& a, std::uint32_t index) { step.weigh(a, index); });
}

/** \brief GeneratePoints, one block a tile. */
template <typename Places>
static __global__ void __launch_bounds__(kTileThreads)
    generatePointsKernel(const GeneratePoints<Places> step, const TileGrid tiles) {
  __shared__ std::uint32_t sums[2];
  if (threadIdx.x < 2) sums[threadIdx.x] = 0;
  std::uint32_t measured_points = 0, gated_points = 0;  // of the warp
  forEachPixelOfTile(tiles, [&](const PixelAddress& a, std::uint32_t index) {
    bool measured = false;
    const WeightedPoint point = step.measure(step.grid.views[a.view], a.u, a.v, measured);
    step.points[index] = point;
    measured_points += __popc(__ballot_sync(0xffffffffu, measured));
    gated_points += __popc(__ballot_sync(0xffffffffu, point.C > 0));
    if (step.use_cells) step.slots[index] = slotOfWarp(step.places, step.keyOf(point, a.view, index), a.view, index);
  });
  if (threadIdx.x % kChunk == 0) {
    atomicAdd(&sums[0], measured_points);
    atomicAdd(&sums[1], gated_points);
  }
  __syncthreads();
  if (threadIdx.x == 0) {
    atomicAdd(step.measured_of_view + tiles.viewOf(blockIdx.x), sums[0]);
    atomicAdd(&step.counts->gated, sums[1]);
  }
}

}  // namespace gpu
}  // namespace fuse_flow

#endif
