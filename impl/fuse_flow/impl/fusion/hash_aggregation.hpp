#pragma once

#include <fuse_flow/impl/fusion/coarse_grid.hpp>
#include <fuse_flow/impl/fusion/fuse_cell.hpp>
#include <fuse_flow/impl/fusion/fused_point_sink.hpp>
#include <fuse_flow/impl/host/parallel.hpp>

#include <algorithm>
#include <cstddef>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief Section 5 over a whole frame, on many threads, with the memory it keeps. */
class HashAggregation {
 public:
  CoarseGrid grid;

  /** \brief Largest L whose children are no smaller than min_cell_size. */
  static int maxLevel(const AggregationParameters& p) {
    int level = 0;
    while (level < 5 && p.cell_size / static_cast<float>(2 << level) >= 0.999f * p.min_cell_size) ++level;
    return level;
  }

  /** \brief Fuses the merged grid's cells; V = 1 without an evaluator. The result's order, which forEachBlock() tells, is that of the
   *  cells, whoever fused them. \param crop_box points that views confirm outside of it are dropped */
  template <typename Points>
  void fuse(const AggregationParameters& p, int threads, const Points& points, const ConsistencyEvaluator* evaluator,
            const Box& crop_box, FusedPointSink& sink) {
    constexpr std::size_t cells_per_block = 8;
    const int max_level = maxLevel(p);
    const std::vector<CoarseGrid::Cell>& cells = grid.cells();
    const std::size_t blocks = (cells.size() + cells_per_block - 1) / cells_per_block;
    if (scratch_.size() < static_cast<std::size_t>(threads)) scratch_.resize(static_cast<std::size_t>(threads));
    fused_.assign(scratch_.size(), 0);
    sink.start(threads);
    blocks_.resize(blocks);
    points_of_cells_.resize(cells.size());
    parallelFor(threads, blocks, [&](std::size_t block, int thread) {
      CellScratch& s = scratch_[static_cast<std::size_t>(thread)];
      Block done{thread, fused_[static_cast<std::size_t>(thread)], 0, 0};
      const std::size_t end = std::min(cells.size(), (block + 1) * cells_per_block);
      for (std::size_t c = block * cells_per_block; c < end; ++c) {
        s.output.clear();
        s.output_cameras.clear();
        fuseCell(p, max_level, grid, cells[c], points, evaluator, crop_box, s);
        done.count += s.output.size();
        points_of_cells_[c] = static_cast<std::uint32_t>(s.output.size());
        sink.add(thread, s.output, s.output_cameras);
      }
      fused_[static_cast<std::size_t>(thread)] += done.count;
      blocks_[block] = done;
    });
    total_ = 0;
    for (Block& block : blocks_) {
      block.offset = total_;
      total_ += block.count;
    }
    reserveForAnyThread(sink);
  }

  std::size_t size() const { return total_; }
  /** \brief How many fused points each cell of the grid gave, in their order. */
  const std::vector<std::uint32_t>& pointsOfCells() const { return points_of_cells_; }

  /** \brief Calls visit(position of the first in the output, thread that fused them, how many it had fused before, how many) for all
   *  fused points, some at a time, in parallel. */
  template <typename Visit>
  void forEachBlock(int threads, const Visit& visit) const {
    constexpr std::size_t blocks_per_task = 16;  // some 100 KB
    parallelFor(threads, (blocks_.size() + blocks_per_task - 1) / blocks_per_task, [&](std::size_t task, int) {
      const std::size_t end = std::min(blocks_.size(), (task + 1) * blocks_per_task);
      for (std::size_t b = task * blocks_per_task; b < end; ++b)
        visit(blocks_[b].offset, blocks_[b].thread, blocks_[b].begin, blocks_[b].count);
    });
  }

 private:
  /** \brief Which thread fuses which block changes from frame to frame: every thread gets the memory that any may need,
   *  so that a warm frame allocates nothing. */
  void reserveForAnyThread(FusedPointSink& sink) {
    std::size_t children = 0, slots = 0, judged = 0, views = 0, normals = 0, confirmations = 0, rows = 0;
    for (const CellScratch& s : scratch_) {
      judged = std::max(judged, s.judged.capacity());
      children = std::max(children, s.children.capacity());
      slots = std::max(slots, s.slot.size());
      views = std::max(views, s.opinions.views());
      normals = std::max(normals, s.normals.capacity());
      confirmations = std::max(confirmations, s.confirmations.capacity());
      rows = std::max(rows, s.occupied.capacity());
    }
    for (CellScratch& s : scratch_) {
      s.output.reserve(children);
      s.output_cameras.reserve(children);
      s.children.reserve(children);
      s.judged.reserve(judged);
      s.judged_camera.reserve(judged);
      s.opinions.reserve(judged, views);
      s.normals.reserve(normals);
      s.confirmations.reserve(confirmations);
      s.V.reserve(judged);
      s.fused.reserve(children);
      s.omega.reserve(children);
      s.kept.reserve(children);
      s.weak.reserve(children);
      s.occupied.reserve(rows);
      s.slot.resize(slots, 0);
    }
    sink.reserve(total_);
  }

  struct Block {
    int thread{0};
    std::size_t begin{0};
    std::size_t count{0};
    std::size_t offset{0};
  };
  std::vector<CellScratch> scratch_;
  std::vector<std::size_t> fused_;  ///< points of each thread
  std::vector<Block> blocks_;
  std::vector<std::uint32_t> points_of_cells_;
  std::size_t total_{0};
};

}  // namespace host
}  // namespace fuse_flow
