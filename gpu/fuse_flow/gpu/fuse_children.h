#pragma once

#include <fuse_flow/gpu/child_runs.h>
#include <fuse_flow/gpu/consistency_evaluator.h>

namespace fuse_flow {
namespace gpu {

/** \brief The child cells that hold points, in the order of their numbers: coarse cell by coarse cell. */
struct Children {
  const WeightedPoint* points;
  const std::uint32_t* slots;  // of each point
  const CoarseCell* cells;     // by slot
  const std::uint32_t* run_children;
  const std::uint32_t* runs;
  /** \brief First run of each child. */
  const std::uint32_t* begins;
  const std::uint32_t* count;
  std::uint32_t run_count;

  FUSE_FLOW_HD std::uint32_t firstPoint(std::uint32_t child) const { return ChildRun::begin(runs[begins[child]]); }
  FUSE_FLOW_HD std::uint32_t slotOf(std::uint32_t child) const { return slots[firstPoint(child)]; }
  FUSE_FLOW_HD std::uint32_t end(std::uint32_t child) const {
    return child + 1 < *count ? begins[child + 1] : run_count;
  }
};

/** \brief Where a coarse cell's children begin, and whose list they walk to measure V. */
struct CellOfChildren {
  std::uint32_t begin;
  std::uint32_t list;
};

/** \brief Section 5 (2) and (3): one child, from its points to its fused point. */
struct FuseChildren {
  Children children;
  AggregationParameters parameters;
  PixelGrid grid;
  ConsistencyEvaluator evaluator;
  bool use_consistency;
  const CellOfChildren* cells;  // by rank

  FusedPoint* fused;
  std::uint8_t* states;

  FUSE_FLOW_HD RepresentativeSelection select(std::uint32_t child, const Vec3& corner) const {
    RepresentativeSelection chosen;
    std::uint32_t camera = 0, camera_begin = 0, camera_end = 0;
    const std::uint32_t end = children.end(child);
    for (std::uint32_t r = children.begins[child]; r < end; ++r) {
      const std::uint32_t run = children.runs[r];
      const std::uint32_t begin = ChildRun::begin(run);
      if (begin < camera_begin || begin >= camera_end) {  // points come camera after camera
        camera = grid.viewOf(begin);
        camera_begin = grid.offsets[camera];
        camera_end = grid.offsets[camera + 1];
      }
      for (std::uint32_t index = begin; index < begin + ChildRun::count(run); ++index) {
        const WeightedPoint point = children.points[index];
        chosen.add(parameters.representatives, point.p - corner, point.C, index, camera);
      }
    }
    chosen.finish();
    return chosen;
  }

  FUSE_FLOW_HD void operator()(std::uint32_t child) const {
    if (child >= *children.count) return;
    const CoarseCell cell = children.cells[children.slotOf(child)];
    const RepresentativeSelection chosen = select(child, cell.corner);
    const bool each = parameters.consistency_at == ConsistencyAt::Representatives;
    float V[kRepresentatives] = {1.0f, 1.0f, 1.0f};
    if (use_consistency) {
      const std::uint32_t list = cells[cell.rank].list;
      if (each) {
        for (int k = 0; k < kRepresentatives; ++k) {
          if (k >= chosen.count()) break;
          const Candidate& c = chosen[k];
          V[k] = evaluator.alongListOf(list, cell.corner + (1.0f / c.sum_C) * c.sum, c.camera);
        }
      } else {
        V[0] = evaluator.alongListOf(list, cell.corner + chosen.mean(), chosen[chosen.main()].camera);
      }
    }
    const FusedPoint point = fuseRepresentatives(chosen, cell.corner, V, each ? 1 : 0);
    fused[child] = point;
    states[child] = stateOf(point.weight);
  }

  /** \brief What becomes of a fused point: see SelectPoints. */
  enum State : std::uint8_t { Dropped, Kept, Weak };

  FUSE_FLOW_HD State stateOf(float weight) const {
    if (!(weight > 0) || weight < parameters.min_weight) return Dropped;
    return weight < parameters.weak_weight ? Weak : Kept;
  }
};

/** \brief Finds where coarse cells begin among the children, and the camera whose list each walks: that of its first
 *  point's child. */
struct FindCells {
  FuseChildren fuse;
  CellTableView table;
  CellOfChildren* cells;  // by rank

  FUSE_FLOW_HD void operator()(std::uint32_t child) const {
    const Children& children = fuse.children;
    if (child >= *children.count) return;
    const std::uint32_t slot = children.slotOf(child);
    const CoarseCell cell = children.cells[slot];
    if (child == 0 || children.slotOf(child - 1) != slot) cells[cell.rank].begin = child;
    if (!fuse.use_consistency || children.firstPoint(child) != table.first[slot]) return;
    const RepresentativeSelection chosen = fuse.select(child, cell.corner);
    const bool each = fuse.parameters.consistency_at == ConsistencyAt::Representatives;
    cells[cell.rank].list = chosen[each ? 0 : chosen.main()].camera;
  }
};

}  // namespace gpu
}  // namespace fuse_flow
