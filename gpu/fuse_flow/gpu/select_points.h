#pragma once

#include <fuse_flow/gpu/fuse_children.h>

namespace fuse_flow {
namespace gpu {

/** \brief What stays of a coarse cell's fused points: all that are strong, and of the weak ones, best first, those beside
 *  which nothing stays. A weak point is decided once all better ones beside it are; in whatever order that happens, the result
 *  is that of the order from best to worst. */
struct SelectPoints {
  Children children;
  const FusedPoint* fused;
  const CellOfChildren* cells;  // by rank
  std::uint32_t cell_count;
  std::uint8_t* states;

  FUSE_FLOW_HD std::uint32_t end(std::uint32_t rank) const {
    return rank + 1 < cell_count ? cells[rank + 1].begin : *children.count;
  }

  FUSE_FLOW_HD std::uint32_t numberOf(std::uint32_t child) const {
    return children.run_children[children.begins[child]];
  }

  /** \brief Heaviest first, ties by position. */
  FUSE_FLOW_HD bool precedes(std::uint32_t a, std::uint32_t b) const {
    return fused[a].weight != fused[b].weight ? fused[a].weight > fused[b].weight : a < b;
  }

  /** \brief The first child of a cell, from begin on, whose number is at least a given one. */
  FUSE_FLOW_HD std::uint32_t lowerBound(std::uint32_t begin, std::uint32_t cell_end, std::uint32_t number) const {
    while (begin < cell_end) {
      const std::uint32_t middle = (begin + cell_end) / 2;
      if (numberOf(middle) < number) {
        begin = middle + 1;
      } else {
        cell_end = middle;
      }
    }
    return begin;
  }

  /** \brief The state of a weak point; Weak: not to be told yet. */
  FUSE_FLOW_HD std::uint8_t decide(std::uint32_t child, const CoarseCell& cell, std::uint32_t begin,
                                   std::uint32_t cell_end) const {
    const int level = static_cast<int>(cell.level);
    const int side = 1 << level;
    const std::uint32_t position = numberOf(child) - cell.first_child_number;
    const int x = static_cast<int>(position) & (side - 1);
    const int y = static_cast<int>(position) >> level & (side - 1);
    const int z = static_cast<int>(position) >> 2 * level;
    const int x_begin = x > 0 ? x - 1 : 0;
    const int x_end = x + 1 < side ? x + 2 : side;
    bool open = false;
    for (int c = z > 0 ? z - 1 : 0; c <= z + 1 && c < side; ++c)
      for (int b = y > 0 ? y - 1 : 0; b <= y + 1 && b < side; ++b) {
        const std::uint32_t row = cell.first_child_number + static_cast<std::uint32_t>(b << level | c << 2 * level);
        const std::uint32_t row_end = row + static_cast<std::uint32_t>(x_end);
        for (std::uint32_t other = lowerBound(begin, cell_end, row + static_cast<std::uint32_t>(x_begin));
             other < cell_end && numberOf(other) < row_end; ++other) {
          if (other == child) continue;
          const std::uint8_t state = stateNow(other);
          if (state == FuseChildren::Kept) return FuseChildren::Dropped;
          open |= state == FuseChildren::Weak && precedes(other, child);
        }
      }
    return open ? FuseChildren::Weak : FuseChildren::Kept;
  }

  /** \brief One round over some of a cell's points: from begin + lane, every lanes-th. Whether some are still open. */
  FUSE_FLOW_HD bool round(const CoarseCell& cell, std::uint32_t begin, std::uint32_t cell_end, std::uint32_t lane,
                          std::uint32_t lanes) const {
    bool open = false;
    for (std::uint32_t child = begin + lane; child < cell_end; child += lanes) {
      if (stateNow(child) != FuseChildren::Weak) continue;
      const std::uint8_t state = decide(child, cell, begin, cell_end);
      open |= state == FuseChildren::Weak;
      *const_cast<volatile std::uint8_t*>(states + child) = state;
    }
    return open;
  }

  /** \brief One cell. */
  FUSE_FLOW_HD void operator()(std::uint32_t rank) const {
    const std::uint32_t begin = cells[rank].begin;
    const CoarseCell cell = children.cells[children.slotOf(begin)];
    while (round(cell, begin, end(rank), 0, 1)) {
    }
  }

 private:
  FUSE_FLOW_HD std::uint8_t stateNow(std::uint32_t child) const {
    return *const_cast<volatile const std::uint8_t*>(states + child);
  }
};

/** \brief Whether a child's point stays. */
struct Stays {
  const std::uint8_t* states;
  FUSE_FLOW_HD bool operator()(std::uint32_t child) const { return states[child] == FuseChildren::Kept; }
};

}  // namespace gpu
}  // namespace fuse_flow
