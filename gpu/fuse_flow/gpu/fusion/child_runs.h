#pragma once

#include <fuse_flow/gpu/fusion/coarse_cells.h>
#include <fuse_flow/gpu/sensors/device_view.h>
#include <fuse_flow/math/representatives.h>

namespace fuse_flow {
namespace gpu {

/** \brief A run: consecutive points of one chunk that fall into one child cell. Half to a third as many as points, which is
 *  what there is to sort. Packed: number of the first point, and one less than how many. */
struct ChildRun {
  static constexpr std::uint32_t kMaxPixels = 1u << 27;  ///< padded pixels of a frame

  FUSE_FLOW_HD static std::uint32_t pack(std::uint32_t begin, std::uint32_t count) { return begin << 5 | (count - 1); }
  FUSE_FLOW_HD static std::uint32_t begin(std::uint32_t run) { return run >> 5; }
  FUSE_FLOW_HD static std::uint32_t count(std::uint32_t run) { return (run & 31u) + 1; }
};

/** \brief Number of the child cell that each point falls into, in the place of its slot. */
struct NumberChildren {
  static constexpr std::uint32_t kNone = CellTableView::kNone;
  const WeightedPoint* points;
  const std::uint32_t* slots;
  const CoarseCell* cells;
  float cell_size;

  FUSE_FLOW_HD std::uint32_t operator()(std::uint32_t index) const {
    const std::uint32_t slot = slots[index];
    if (slot == CellTableView::kNone) return kNone;
    const CoarseCell cell = cells[slot];
    return cell.first_child_number + childPosition(points[index].p - cell.corner, static_cast<int>(cell.level),
                                                   childrenPerMetre(static_cast<int>(cell.level), cell_size));
  }
};

/** \brief Numbers the children of a chunk's points, and counts its runs. */
struct CountRuns {
  NumberChildren number;
  std::uint32_t* numbers;  // of each point
  std::uint32_t* runs;     // of each chunk

  FUSE_FLOW_HD void operator()(std::uint32_t chunk) const {
    std::uint32_t count = 0, before = NumberChildren::kNone;
    for (std::uint32_t index = chunk * kChunk; index < (chunk + 1) * kChunk; ++index) {
      const std::uint32_t child = number(index);
      count += child != NumberChildren::kNone && child != before ? 1 : 0;
      before = child;
      numbers[index] = child;
    }
    runs[chunk] = count;
  }
};

/** \brief Writes a chunk's runs to their place. */
struct WriteRuns {
  const std::uint32_t* numbers;
  const std::uint32_t* places;  // of each chunk's first run
  std::uint32_t* run_children;
  std::uint32_t* runs;

  FUSE_FLOW_HD void operator()(std::uint32_t chunk) const {
    std::uint32_t place = places[chunk];
    const std::uint32_t end = (chunk + 1) * kChunk;
    std::uint32_t index = chunk * kChunk;
    while (index < end) {
      const std::uint32_t child = numbers[index];
      const std::uint32_t begin = index;
      while (index < end && numbers[index] == child) ++index;
      if (child == NumberChildren::kNone) continue;
      run_children[place] = child;
      runs[place] = ChildRun::pack(begin, index - begin);
      ++place;
    }
  }
};

/** \brief Whether a sorted run is the first of its child. */
struct BeginsChild {
  const std::uint32_t* run_children;
  FUSE_FLOW_HD bool operator()(std::uint32_t run) const {
    return run == 0 || run_children[run] != run_children[run - 1];
  }
};

}  // namespace gpu
}  // namespace fuse_flow
