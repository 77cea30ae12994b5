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

  FUSE_FLOW_HD std::uint32_t end(std::uint32_t child) const {
    return child + 1 < *count ? begins[child + 1] : run_count;
  }
  FUSE_FLOW_HD std::uint32_t numberOf(std::uint32_t child) const { return run_children[begins[child]]; }

  /** \brief The first of children [begin, end) whose number is at least a given one; else end. */
  FUSE_FLOW_HD std::uint32_t lowerBound(std::uint32_t begin, std::uint32_t end_child, std::uint32_t number) const {
    while (begin < end_child) {
      const std::uint32_t middle = (begin + end_child) / 2;
      if (numberOf(middle) < number) {
        begin = middle + 1;
      } else {
        end_child = middle;
      }
    }
    return begin;
  }
};

/** \brief Section 5 (2) a: a child's representatives. */
struct SelectRepresentatives {
  Children children;
  Representatives mode;
  PixelGrid grid;

  FUSE_FLOW_HD RepresentativeSelection operator()(std::uint32_t child, const Vec3& corner) const {
    RepresentativeSelection chosen;
    std::uint32_t camera = 0, camera_begin = 0, camera_end = 0;
    const std::uint32_t end = children.end(child);
    std::uint32_t r = children.begins[child];
    std::uint32_t run = children.runs[r];
    WeightedPoint point = children.points[ChildRun::begin(run)];
    for (; r < end; ++r) {
      // The next run's first point is on its way from memory while this run is worked on.
      const std::uint32_t next_run = r + 1 < end ? children.runs[r + 1] : run;
      const WeightedPoint next_point = children.points[ChildRun::begin(next_run)];
      const std::uint32_t begin = ChildRun::begin(run);
      if (begin < camera_begin || begin >= camera_end) {  // points come camera after camera
        camera = grid.viewOf(begin);
        camera_begin = grid.offsets[camera];
        camera_end = grid.offsets[camera + 1];
      }
      chosen.add(mode, point.p - corner, point.C, begin, camera);
      for (std::uint32_t index = begin + 1; index < begin + ChildRun::count(run); ++index) {
        const WeightedPoint further = children.points[index];
        chosen.add(mode, further.p - corner, further.C, index, camera);
      }
      run = next_run;
      point = next_point;
    }
    chosen.finish();
    return chosen;
  }
};

/** \brief Where a coarse cell's children begin, and whose list they walk to measure V. */
struct CellOfChildren {
  std::uint32_t begin;
  std::uint32_t list;
  std::uint32_t slot;
};

/** \brief Finds where a coarse cell begins among the children, and the camera whose list its points walk: that of its
 *  first point's child. */
struct FindCells {
  SelectRepresentatives select;
  bool each;
  const std::uint32_t* order;         // rank → slot
  const std::uint32_t* first_points;  // by rank
  const std::uint32_t* numbers;       // of each point's child
  CellOfChildren* cells;              // by rank

  FUSE_FLOW_HD void operator()(std::uint32_t rank) const {
    const Children& children = select.children;
    const std::uint32_t slot = order[rank];
    const CoarseCell cell = children.cells[slot];
    const std::uint32_t begin = children.lowerBound(0, *children.count, cell.first_child_number);
    const std::uint32_t child = children.lowerBound(begin, *children.count, numbers[first_points[rank]]);
    const RepresentativeSelection chosen = select(child, cell.corner);
    cells[rank] = {begin, each ? chosen[0].camera : chosen.mainCamera(), slot};
  }
};

/** \brief Section 5 (2) and (3): one child, from its points to its fused point. */
struct FuseChildren {
  SelectRepresentatives select;
  AggregationParameters parameters;
  ConsistencyEvaluator evaluator;
  bool use_consistency;
  const CellOfChildren* cells;  // by rank

  FusedPoint* fused;
  /** \brief ω of each child's point, and the child's position in its coarse cell. */
  float* weights;
  std::uint16_t* positions;
  std::uint8_t* states;

  /** \brief What becomes of a fused point: see SelectPoints. */
  enum State : std::uint8_t { Dropped, Kept, Weak };

  FUSE_FLOW_HD void operator()(std::uint32_t child) const {
    const Children& children = select.children;
    if (child >= *children.count) return;
    const std::uint32_t slot = children.slots[ChildRun::begin(children.runs[children.begins[child]])];
    const CoarseCell cell = children.cells[slot];
    const RepresentativeSelection chosen = select(child, cell.corner);
    const bool each = parameters.consistency_at == ConsistencyAt::Representatives;
    float V[kRepresentatives] = {1.0f, 1.0f, 1.0f};
    if (use_consistency) {
      const std::uint32_t list = cells[cell.rank].list;
      for (int k = 0; k < (each ? chosen.count() : 1); ++k) {
        const Candidate c = chosen[k];
        const Vec3 judged = cell.corner + (each ? (1.0f / c.sum_C) * c.sum : chosen.mean());
        const float v = evaluator.alongListOf(list, judged, each ? c.camera : chosen.mainCamera());
        if (k == 0) V[0] = v;  // constant indices: V stays in registers
        if (k == 1) V[1] = v;
        if (k == 2) V[2] = v;
      }
    }
    const FusedPoint point = fuseRepresentatives(chosen, cell.corner, V, each ? 1 : 0);
    fused[child] = point;
    weights[child] = point.weight;
    positions[child] = static_cast<std::uint16_t>(children.numberOf(child) - cell.first_child_number);
    states[child] = stateOf(point.weight);
  }

  FUSE_FLOW_HD State stateOf(float weight) const {
    if (!(weight > 0) || weight < parameters.min_weight) return Dropped;
    return weight < parameters.weak_weight ? Weak : Kept;
  }
};

}  // namespace gpu
}  // namespace fuse_flow
