#pragma once

#include <fuse_flow/gpu/cell_table.h>
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

/** \brief The slots in use and their first points, to be sorted by these. */
struct ListCells {
  CellTableView table;
  std::uint32_t* first_points;
  std::uint32_t* slots;

  FUSE_FLOW_HD void operator()(std::uint32_t k) const {
    slots[k] = table.slots[k];
    first_points[k] = table.first[table.slots[k]];
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
