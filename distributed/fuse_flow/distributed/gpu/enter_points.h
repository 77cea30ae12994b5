#pragma once

#include <fuse_flow/distributed/gpu/device_windows.h>
#include <fuse_flow/gpu/fusion/generate_points_kernel.h>
#include <fuse_flow/gpu/runtime/execution.h>

namespace fuse_flow {
namespace distributed {

/** \brief Puts points into their coarse cells. */
struct EnterPoints {
  gpu::CoarseCells cells;
  float inverse_cell_size;
  const WeightedPoint* points;
  std::uint32_t* slots;  ///< of each point's cell; kNone where nothing is entered

  FUSE_FLOW_HD std::uint64_t keyOf(std::uint32_t index) const {
    return cellKey(cellIndex(inverse_cell_size * points[index].p));
  }

  /** \brief Consecutive pixels of one view. \param wanted whether the point of a pixel is entered */
  template <typename Wanted>
  FUSE_FLOW_HD void enter(std::uint32_t view, std::uint32_t begin, std::uint32_t count, const Wanted& wanted) const {
    std::uint64_t run_key = gpu::CellTableView::kEmpty;
    std::uint32_t run_begin = begin, run_slot = gpu::CellTableView::kNone;
    for (std::uint32_t index = begin; index <= begin + count; ++index) {
      const bool enters = index < begin + count && wanted(index);
      const std::uint64_t key = enters ? keyOf(index) : gpu::CellTableView::kEmpty;
      if (key != run_key) {
        if (run_key != gpu::CellTableView::kEmpty) cells.addPoints(run_slot, view, run_begin, index - run_begin);
        run_key = key;
        run_begin = index;
        run_slot = enters ? cells.table.findOrAdd(key) : gpu::CellTableView::kNone;
      }
      if (enters) slots[index] = run_slot;
    }
  }
};

/** \brief Points of own views in cells that the rank fuses, a chunk at a time. */
struct EnterOwnPoints {
  EnterPoints points;
  gpu::TileGrid tiles;               ///< of own views alone
  const std::uint32_t* block_slots;  ///< of each pixel's point; kNone: no point
  const std::int32_t* owners;        ///< of each slot
  std::int32_t own;

  FUSE_FLOW_HD bool wants(std::uint32_t index) const {
    const std::uint32_t slot = block_slots[index];
    return slot != gpu::CellTableView::kNone && owners[slot] == own;
  }
  FUSE_FLOW_HD void operator()(std::uint32_t chunk) const {
    const std::uint32_t begin = chunk * gpu::kChunk;
    const std::uint32_t view = tiles.pixels.viewOf(begin);
    if (tiles.offsets[view] < tiles.offsets[view + 1])
      points.enter(view, begin, gpu::kChunk, [this](std::uint32_t index) { return wants(index); });
  }
};

/** \brief Points that came from other ranks, a group at a time: all of them are in cells that the rank fuses. */
struct EnterReceivedPoints {
  EnterPoints points;
  const gpu::DeviceView* views;
  WindowList list;

  FUSE_FLOW_HD bool wants(std::uint32_t index) const { return points.points[index].C > 0; }
  FUSE_FLOW_HD void operator()(std::uint32_t group) const {
    const WindowList::Place at = list.placeOf(group);
    const std::uint32_t view = at.window->view;
    points.enter(view, views[view].indexOf(at.u, at.v), kPixelGroup,
                 [this](std::uint32_t index) { return wants(index); });
  }
};

#if FUSE_FLOW_CUDA
/** \brief EnterOwnPoints, one block a tile. */
static __global__ void __launch_bounds__(gpu::kTileThreads) enterOwnPointsKernel(const EnterOwnPoints step) {
  gpu::forEachPixelOfTile(step.tiles, [&step](const gpu::PixelAddress& a, std::uint32_t index) {
    const bool enters = step.wants(index);
    const std::uint64_t key = enters ? step.points.keyOf(index) : gpu::CellTableView::kEmpty;
    step.points.slots[index] = gpu::slotOfWarp(step.points.cells, key, a.view, index);
  });
}

constexpr unsigned int kEnterThreads = 256;

/** \brief EnterReceivedPoints, one thread a pixel. A warp may have pixels of several rows and windows: their numbers ascend. */
static __global__ void __launch_bounds__(kEnterThreads)
    enterReceivedPointsKernel(const EnterReceivedPoints step, std::uint32_t groups) {
  const std::uint32_t k = blockIdx.x * kEnterThreads + threadIdx.x;
  const bool there = k / kPixelGroup < groups;
  std::uint32_t index = 0, view = 0;
  if (there) {
    const WindowList::Place at = step.list.placeOf(k / kPixelGroup);
    view = at.window->view;
    index = step.views[view].indexOf(at.u, at.v) + k % kPixelGroup;
  }
  const std::uint64_t key = there && step.wants(index) ? step.points.keyOf(index) : gpu::CellTableView::kEmpty;
  const std::uint32_t slot = gpu::slotOfWarp(step.points.cells, key, view, index);
  if (there) step.points.slots[index] = slot;
}
#endif

/** \param chunks of all pixels */
inline void enterOwnPoints(gpu::Execution& run, const EnterOwnPoints& step, std::size_t chunks) {
#if FUSE_FLOW_CUDA
  (void)chunks;
  run.launch("enterOwnPointsKernel", enterOwnPointsKernel, step.tiles.count, gpu::kTileThreads, step);
#else
  run.forEach(chunks, step);
#endif
}

/** \param groups of the received windows */
inline void enterReceivedPoints(gpu::Execution& run, const EnterReceivedPoints& step, std::size_t groups) {
#if FUSE_FLOW_CUDA
  const std::size_t blocks = (groups * kPixelGroup + kEnterThreads - 1) / kEnterThreads;
  run.launch("enterReceivedPointsKernel", enterReceivedPointsKernel, static_cast<unsigned int>(blocks), kEnterThreads,
             step, static_cast<std::uint32_t>(groups));
#else
  run.forEach(groups, step);
#endif
}

}  // namespace distributed
}  // namespace fuse_flow
