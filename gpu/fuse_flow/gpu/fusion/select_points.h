#pragma once

#include <fuse_flow/gpu/fusion/fuse_children.h>

namespace fuse_flow {
namespace gpu {

/** \brief What stays of a coarse cell's fused points: all that are strong, and of the weak ones, best first, those beside
 *  which nothing stays. A weak point is decided once all better ones beside it are; in whatever order that happens, the result
 *  is that of the order from best to worst. */
struct SelectPoints {
  const float* weights;            // of each child
  const std::uint16_t* positions;  // of each child in its coarse cell, ascending
  const CellOfChildren* cells;     // by rank
  const CoarseCell* coarse_cells;  // by slot
  const std::uint32_t* child_count;
  std::uint32_t cell_count;
  std::uint8_t* states;

  FUSE_FLOW_HD std::uint32_t end(std::uint32_t rank) const {
    return rank + 1 < cell_count ? cells[rank + 1].begin : *child_count;
  }
  FUSE_FLOW_HD int level(std::uint32_t rank) const { return static_cast<int>(coarse_cells[cells[rank].slot].level); }

  /** \brief Calls visit(row, x_begin, x_end) for the rows of children around a position: those at row + x. */
  template <typename Visit>
  FUSE_FLOW_HD static void forEachRowAround(int position, int level, const Visit& visit) {
    const int side = 1 << level;
    const int x = position & (side - 1);
    const int y = position >> level & (side - 1);
    const int z = position >> 2 * level;
    for (int c = z > 0 ? z - 1 : 0; c <= z + 1 && c < side; ++c)
      for (int b = y > 0 ? y - 1 : 0; b <= y + 1 && b < side; ++b)
        visit(b << level | c << 2 * level, x > 0 ? x - 1 : 0, x + 1 < side ? x + 2 : side);
  }

  /** \brief One cell. */
  FUSE_FLOW_HD void operator()(std::uint32_t rank) const {
    const std::uint32_t begin = cells[rank].begin;
    const std::uint32_t cell_end = end(rank);
    const int cell_level = level(rank);
    for (bool open = true; open;) {
      open = false;
      for (std::uint32_t child = begin; child < cell_end; ++child) {
        if (states[child] != Weak) continue;
        states[child] = decide(child, cell_level, begin, cell_end);
        open |= states[child] == Weak;
      }
    }
  }

 private:
  /** \brief The state of a weak point; Weak: not to be told yet. */
  FUSE_FLOW_HD std::uint8_t decide(std::uint32_t child, int cell_level, std::uint32_t begin,
                                   std::uint32_t cell_end) const {
    bool open = false, beaten = false;
    forEachRowAround(positions[child], cell_level, [&](int row, int x_begin, int x_end) {
      for (std::uint32_t other = lowerBound(begin, cell_end, row + x_begin);
           other < cell_end && positions[other] < row + x_end; ++other) {
        if (other == child) continue;
        beaten |= states[other] == Kept;
        open |= states[other] == Weak && precedes(other, child);
      }
    });
    if (beaten) return Dropped;
    return open ? Weak : Kept;
  }

  /** \brief Heaviest first, ties by position. */
  FUSE_FLOW_HD bool precedes(std::uint32_t a, std::uint32_t b) const {
    return weights[a] != weights[b] ? weights[a] > weights[b] : a < b;
  }

  FUSE_FLOW_HD std::uint32_t lowerBound(std::uint32_t begin, std::uint32_t cell_end, int position) const {
    while (begin < cell_end) {
      const std::uint32_t middle = (begin + cell_end) / 2;
      if (positions[middle] < position) {
        begin = middle + 1;
      } else {
        cell_end = middle;
      }
    }
    return begin;
  }
};

}  // namespace gpu
}  // namespace fuse_flow
