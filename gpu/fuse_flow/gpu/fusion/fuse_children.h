#pragma once

#include <fuse_flow/gpu/fusion/child_runs.h>
#include <fuse_flow/gpu/fusion/consistency_evaluator.h>

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
  /** \brief Number of a child's first point. */
  FUSE_FLOW_HD std::uint32_t firstPoint(std::uint32_t child) const { return ChildRun::begin(runs[begins[child]]); }
  FUSE_FLOW_HD std::uint32_t slotOf(std::uint32_t child) const { return slots[firstPoint(child)]; }
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

/** \brief Where a coarse cell's children begin, and the child of its first point: the cell's points walk the list of that
 *  child's camera to measure V. */
struct CellOfChildren {
  std::uint32_t begin;
  std::uint32_t first;
  std::uint32_t slot;
};

/** \brief Finds the coarse cell of each child, and the child's position in it. */
struct FindCells {
  Children children;
  const std::uint32_t* first_points;  // by rank
  CellOfChildren* cells;              // by rank
  std::uint32_t* ranks;               // of each child's cell
  std::uint16_t* positions;           // of each child

  FUSE_FLOW_HD void operator()(std::uint32_t child) const {
    if (child >= *children.count) return;
    const std::uint32_t first_point = children.firstPoint(child);
    const std::uint32_t slot = children.slots[first_point];
    const CoarseCell cell = children.cells[slot];
    ranks[child] = cell.rank;
    positions[child] = static_cast<std::uint16_t>(children.numberOf(child) - cell.first_child_number);
    if (child == 0 || children.slotOf(child - 1) != slot) {
      cells[cell.rank].begin = child;
      cells[cell.rank].slot = slot;
    }
    if (first_point == first_points[cell.rank]) cells[cell.rank].first = child;
  }
};

/** \brief The cameras of a child's representatives but the highest-ranking one, in 32 bits. Of a rig of 65,535 cameras or more the last ones
 *  are not told apart. */
struct OtherCameras {
  static constexpr std::uint32_t kNone = 0xffff;

  FUSE_FLOW_HD static std::uint32_t of(const RepresentativeSelection& chosen) {
    const int main = chosen.main();
    std::uint32_t packed = kNone << 16 | kNone;
    for (int k = 0; k < kRepresentatives; ++k) {
      if (k >= chosen.count() || k == main) continue;
      const std::uint32_t camera = chosen[k].camera;
      packed = packed << 16 | (camera < kNone ? camera : kNone);
    }
    return packed;
  }
  template <typename Cameras>
  FUSE_FLOW_HD static void addTo(Cameras& cameras, std::uint32_t packed) {
    if (packed >> 16 != kNone) cameras.addRepresentative(packed >> 16);
    if ((packed & kNone) != kNone) cameras.addRepresentative(packed & kNone);
  }
};

/** \brief Section 5 (2) a and (3): one child, from its points to its fused point with V = 1. */
struct FuseChildren {
  SelectRepresentatives select;
  FusedPoint* fused;
  /** \brief Of each child's highest-ranking representative. */
  std::uint32_t* cameras;
  /** \brief OtherCameras of each child. */
  std::uint32_t* others;

  FUSE_FLOW_HD void operator()(std::uint32_t child) const {
    const Children& children = select.children;
    if (child >= *children.count) return;
    const Vec3 corner = children.cells[children.slotOf(child)].corner;
    const RepresentativeSelection chosen = select(child, corner);
    fused[child] = fuseRepresentatives(chosen, corner, nullptr);
    cameras[child] = chosen.mainCamera();
    others[child] = OtherCameras::of(chosen);
  }
};

/** \brief What becomes of a fused point: see SelectPoints. */
enum PointState : std::uint8_t { Dropped, Kept, Weak };

FUSE_FLOW_HD PointState stateOf(const AggregationParameters& p, float weight) {
  if (!(weight > 0) || weight < p.min_weight) return Dropped;
  return weight < p.weak_weight ? Weak : Kept;
}

/** \brief The point of the highest-ranking representative; see outranks(). Before V has changed the shares. */
FUSE_FLOW_HD std::uint32_t mainSource(const FusedPoint& fused) {
  std::uint32_t source = fused.source[0];
  float most = fused.share[0];
  for (std::uint32_t k = 1; k < kRepresentatives; ++k) {
    if (k >= fused.count) continue;  // not break: compilers then unroll
    const bool higher = fused.share[k] != most ? fused.share[k] > most : fused.source[k] < source;
    if (!higher) continue;
    source = fused.source[k];
    most = fused.share[k];
  }
  return source;
}

/** \brief ConsistencyAt::CellMean: V once a child, at its fused point, which one V does not move; what other views confirm there
 *  does, afterwards. \tparam Cameras PointCameras, or PointCameraCount where nobody asks for masks */
template <typename Cameras>
struct JudgeChildren {
  AggregationParameters parameters;
  ConsistencyEvaluator evaluator;
  bool use_consistency;
  FusedPoint* fused;
  const std::uint32_t* cameras;
  const std::uint32_t* ranks;
  const CellOfChildren* cells;  // by rank
  const std::uint32_t* count;
  float* weights;
  std::uint8_t* states;
  /** \brief OtherCameras of each child; becomes PointCameras::count(). */
  std::uint32_t* view_counts;
  /** \brief Null, or receives PointCameras::mask(). */
  std::uint64_t* masks;

  FUSE_FLOW_HD void writeCameras(std::uint32_t child, const Cameras& of) const {
    view_counts[child] = of.count();
    if (masks != nullptr) masks[child] = of.mask();
  }

  FUSE_FLOW_HD void operator()(std::uint32_t child) const {
    if (child >= *count) return;
    Cameras from;
    from.addRepresentative(cameras[child]);
    OtherCameras::addTo(from, view_counts[child]);
    const std::uint32_t list = cameras[cells[ranks[child]].first];
    float weight = fused[child].weight;
    if (use_consistency) {
      const Vec3 p = fused[child].p, normal = evaluator.normalAt(cameras[child], mainSource(fused[child]));
      Confirmation confirmation;
      const float V = evaluator.alongListOf(list, p, normal, cameras[child], evaluator.refined, confirmation, from);
      if (evaluator.refined != nullptr) fused[child].p = confirmation.moved(p, weight);
      weight *= V;
    }
    writeCameras(child, from);
    weights[child] = weight;
    states[child] = stateOf(parameters, weight);
  }
};

/** \brief ConsistencyAt::Representatives: V of every representative, and the fused point again. */
template <typename Cameras>
struct JudgeRepresentatives {
  SelectRepresentatives select;
  JudgeChildren<Cameras> judge;
  FusedPoint* fused;

  FUSE_FLOW_HD void operator()(std::uint32_t child) const {
    const Children& children = select.children;
    if (child >= *children.count) return;
    const Vec3 corner = children.cells[children.slotOf(child)].corner;
    const RepresentativeSelection chosen = select(child, corner);
    const std::uint32_t first = judge.cells[judge.ranks[child]].first;
    const std::uint32_t list = select(first, corner)[0].camera;
    float V[kRepresentatives] = {1.0f, 1.0f, 1.0f};
    Cameras from;
    for (int k = 0; k < kRepresentatives; ++k)
      if (k < chosen.count()) from.addRepresentative(chosen[k].camera);
    const int main = chosen.main();
    for (int k = 0; k < kRepresentatives; ++k) {
      if (k >= chosen.count()) continue;  // not break: V then stays in registers
      const Candidate c = chosen[k];
      const Vec3 p = corner + (1.0f / c.sum_C) * c.sum;
      const Vec3 normal = judge.evaluator.normalAt(c.camera, c.best);
      V[k] = k == main ? judge.evaluator.alongListOf(list, p, normal, c.camera, from)
                       : judge.evaluator.alongListOf(list, p, normal, c.camera);
    }
    const FusedPoint point = fuseRepresentatives(chosen, corner, V);
    fused[child] = point;
    judge.writeCameras(child, from);
    judge.weights[child] = point.weight;
    judge.states[child] = stateOf(judge.parameters, point.weight);
  }
};

}  // namespace gpu
}  // namespace fuse_flow
