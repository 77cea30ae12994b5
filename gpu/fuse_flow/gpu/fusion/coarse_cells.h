#pragma once

#include <fuse_flow/gpu/fusion/cell_table.h>
#include <fuse_flow/math/adaptive_hash.h>

namespace fuse_flow {
namespace gpu {

/** \brief What every point of a coarse cell needs to know of it. */
struct alignas(8) CoarseCell {
  Vec3 corner;
  /** \brief Number of its first child: children of all cells are numbered cell by cell, position by position. */
  std::uint32_t first_child_number;
  /** \brief Place among the cells, by their first points: the order in which the CPU meets them. */
  std::uint32_t rank;
  std::uint32_t level;
};

/** \brief Cells come in the order of their first points. Those are marked, one bit a point, and a cell's rank is the number of
 *  bits before its own: cheaper than a sort of the cells. */
struct MarkFirstPoints {
  CellTableView table;
  std::uint32_t* marks;  // a word for every 32 points

  FUSE_FLOW_HD void operator()(std::uint32_t k) const {
    const std::uint32_t point = table.first[table.slots[k]];
    atomicOrTo(marks + point / 32, 1u << point % 32);
  }
};

/** \brief Bits in a word of marks. */
struct CountMarks {
  using result_type = std::uint32_t;
  const std::uint32_t* marks;
  FUSE_FLOW_HD std::uint32_t operator()(std::uint32_t word) const { return countBits(marks[word]); }
};

/** \brief Puts the slots in use, and their first points, in order. */
struct RankCells {
  CellTableView table;
  const std::uint32_t* marks;
  const std::uint32_t* marks_before;  // each word
  std::uint32_t* first_points;        // by rank
  std::uint32_t* slots;               // by rank

  FUSE_FLOW_HD void operator()(std::uint32_t k) const {
    const std::uint32_t slot = table.slots[k];
    const std::uint32_t point = table.first[slot];
    const std::uint32_t before = marks[point / 32] & ((1u << point % 32) - 1);
    const std::uint32_t rank = marks_before[point / 32] + countBits(before);
    first_points[rank] = point;
    slots[rank] = slot;
  }
};

/** \brief Section 5 (1) d: how many children a cell is split into, cell by cell in their order. */
struct ChildrenOfCell {
  using result_type = std::uint64_t;
  CellTableView table;
  const std::uint32_t* slots;
  float points_per_cell;
  int max_level;

  FUSE_FLOW_HD int level(std::uint32_t rank) const {
    return refinementLevel(table.counts[slots[rank]], points_per_cell, max_level);
  }
  FUSE_FLOW_HD std::uint64_t operator()(std::uint32_t rank) const { return std::uint64_t{1} << 3 * level(rank); }
};

/** \brief Describes the cell in each slot. */
struct DescribeCells {
  ChildrenOfCell children;
  const std::uint64_t* first_child_numbers;
  float cell_size;
  CoarseCell* cells;  // by slot

  FUSE_FLOW_HD void operator()(std::uint32_t rank) const {
    const std::uint32_t slot = children.slots[rank];
    cells[slot] = {cellCorner(children.table.keys[slot], cell_size),
                   static_cast<std::uint32_t>(first_child_numbers[rank]), rank,
                   static_cast<std::uint32_t>(children.level(rank))};
  }
};

}  // namespace gpu
}  // namespace fuse_flow
