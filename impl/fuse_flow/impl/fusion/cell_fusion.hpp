#pragma once

#include <fuse_flow/impl/fusion/cell_points.hpp>
#include <fuse_flow/impl/fusion/coarse_grid.hpp>
#include <fuse_flow/impl/fusion/consistency_evaluator.hpp>
#include <fuse_flow/math/adaptive_hash.h>
#include <fuse_flow/math/box.h>
#include <fuse_flow/math/representatives.h>

#include <algorithm>
#include <new>

namespace fuse_flow {
namespace host {

/** \brief A child of a coarse cell while its points are collected. */
struct Child {
  RepresentativeSelection chosen;
  std::uint32_t position;

  explicit Child(std::uint32_t where) : position(where) {}
};

/** \brief A fused point that stays only where nothing better does. */
struct WeakPoint {
  float weight;
  std::uint32_t position;  ///< of its child
  std::uint32_t number;
};

/** \brief Which children of a coarse cell have something, a bit each: rows along x, with empty ones around them. */
class ChildBits {
 public:
  /** \brief Begins with a cell of 2^level children along an axis, all of them empty. */
  void clear(int level) {
    level_ = level;
    const int side = (1 << level) + 2;
    rows_.assign(static_cast<std::size_t>(side * side), 0);
  }

  std::size_t capacity() const { return rows_.capacity(); }
  void reserve(std::size_t rows) { rows_.reserve(rows); }

  /** \param position childPosition() */
  void set(std::uint32_t position) { rows_[row(position)] |= std::uint64_t{2} << x(position); }

  /** \brief Whether a child or one of the 26 around it has something. */
  bool anyAround(std::uint32_t position) const {
    const std::size_t side = (std::size_t{1} << level_) + 2;
    const std::uint64_t* first = rows_.data() + row(position) - side - 1;
    std::uint64_t any = 0;
    for (std::size_t z = 0; z < 3; ++z)
      for (std::size_t y = 0; y < 3; ++y) any |= first[z * side + y];
    return (any >> x(position) & 7) != 0;
  }

 private:
  std::uint32_t x(std::uint32_t position) const { return position & ((1u << level_) - 1); }
  std::size_t row(std::uint32_t position) const {
    const std::size_t y = position >> level_ & ((1u << level_) - 1), z = position >> 2 * level_;
    return (z + 1) * ((std::size_t{1} << level_) + 2) + y + 1;
  }

  int level_{0};
  std::vector<std::uint64_t> rows_;
};

/** \brief Per-thread memory of fuseCell(); kept from frame to frame. */
struct CellScratch {
  CellPoints points;
  std::vector<std::uint32_t> slot;  // child position → 1 + number of the child
  std::vector<Child> children;
  std::vector<Vec3> judged;  // where V is measured, child after child
  std::vector<std::uint32_t> judged_camera;
  CellOpinions opinions;
  CellConfirmations confirmations;
  std::vector<float> V;
  std::vector<FusedPoint> fused;
  std::vector<float> omega;  // of each fused point, before one V of the child's has multiplied it
  std::vector<std::uint8_t> kept;
  std::vector<WeakPoint> weak;
  ChildBits occupied;  // by points that stay
  std::vector<FusedPoint> output;
  std::vector<std::uint64_t> output_cameras;  // PointCameras::mask() of each
};

/** \brief Receives the fused points of a frame, those of one coarse cell at a time. */
class FusedPointSink {
 public:
  virtual ~FusedPointSink() = default;
  /** \brief Before the first point of a frame. */
  virtual void start(int threads) = 0;
  /** \brief Points that a thread has fused, after those that it has added before. \param cameras PointCameras::mask() of each */
  virtual void add(int thread, const std::vector<FusedPoint>& points, const std::vector<std::uint64_t>& cameras) = 0;
  /** \brief Room for so many points on every thread, so that a warm frame allocates nothing. */
  virtual void reserve(std::size_t points) = 0;
};

/** \brief Section 5 (2) b: V of every representative, or of every cell's mean, child after child; and what other views
 *  confirm there. */
inline void measureConsistency(ConsistencyAt at, const Vec3& corner, float cell_size,
                               const ConsistencyEvaluator* evaluator, CellScratch& scratch) {
  const std::size_t per_child = at == ConsistencyAt::CellMean ? 1 : kRepresentatives;
  scratch.judged.resize(per_child * scratch.children.size());
  scratch.judged_camera.resize(scratch.judged.size());
  std::size_t n = 0;
  for (Child& child : scratch.children) {
    child.chosen.finish();
    if (at == ConsistencyAt::CellMean) {
      scratch.judged[n] = corner + child.chosen.mean();
      scratch.judged_camera[n++] = child.chosen.mainCamera();
    } else {
      for (int k = 0; k < child.chosen.count(); ++k) {
        const Candidate c = child.chosen[k];
        scratch.judged[n] = corner + (1.0f / c.sum_C) * c.sum;
        scratch.judged_camera[n++] = c.camera;
      }
    }
  }
  scratch.judged.resize(n);
  scratch.judged_camera.resize(n);
  scratch.V.assign(scratch.judged.size(), 1.0f);
  if (evaluator == nullptr) return;
  const float half = 0.5f * cell_size;
  const Bounds cell{corner + Vec3{half, half, half}, {half, half, half}};
  evaluator->evaluate(cell, scratch.judged.data(), scratch.judged_camera.data(), scratch.judged.size(),
                      scratch.opinions, scratch.V.data());
}

/** \brief Marks what stays of a coarse cell's fused points: all that are strong, and of the weak ones, best first,
 *  those beside which nothing stays. So doubtful measurements never crowd out or double good ones, and a surface that
 *  only doubtful ones show thins out instead of vanishing. */
inline void selectPoints(const AggregationParameters& p, int level, CellScratch& scratch) {
  const std::vector<FusedPoint>& fused = scratch.fused;
  scratch.kept.assign(fused.size(), 0);
  scratch.weak.clear();
  for (std::uint32_t k = 0; k < fused.size(); ++k) {
    if (!(fused[k].weight > 0) || fused[k].weight < p.min_weight) continue;
    if (fused[k].weight < p.weak_weight) {
      scratch.weak.push_back({fused[k].weight, scratch.children[k].position, k});
    } else {
      scratch.kept[k] = 1;
    }
  }
  if (scratch.weak.empty()) return;
  scratch.occupied.clear(level);
  for (std::size_t k = 0; k < fused.size(); ++k)
    if (scratch.kept[k]) scratch.occupied.set(scratch.children[k].position);
  // Most have a strong one beside them, whatever their order.
  scratch.weak.erase(std::remove_if(scratch.weak.begin(), scratch.weak.end(),
                                    [&](const WeakPoint& point) { return scratch.occupied.anyAround(point.position); }),
                     scratch.weak.end());
  std::sort(scratch.weak.begin(), scratch.weak.end(), [](const WeakPoint& a, const WeakPoint& b) {
    return a.weight != b.weight ? a.weight > b.weight : a.position < b.position;
  });
  for (const WeakPoint& point : scratch.weak) {
    if (scratch.occupied.anyAround(point.position)) continue;
    scratch.kept[point.number] = 1;
    scratch.occupied.set(point.position);
  }
}

/** \brief What other views confirm about the points that stay, point after point. */
inline void readConfirmed(const ConsistencyEvaluator& evaluator, CellScratch& scratch) {
  scratch.confirmations.clear();
  scratch.confirmations.reserve(Confirmation::kViews * scratch.kept.size());
  for (std::size_t k = 0; k < scratch.kept.size(); ++k)
    if (scratch.kept[k]) evaluator.prefetchConfirmed(scratch.opinions, k);
  for (std::size_t k = 0; k < scratch.kept.size(); ++k)
    if (scratch.kept[k]) evaluator.readConfirmed(scratch.opinions, k, scratch.confirmations);
  evaluator.weighConfirmed(scratch.confirmations);
}

/** \brief Section 5 (2) a: hands the points that were read to the children they fall into. */
inline void addToChildren(Representatives mode, CellScratch& scratch) {
  const CellPoints& points = scratch.points;
  std::size_t k = 0;
  for (std::size_t i = 0; i < points.pieces; ++i) {
    const CellPoints::Piece piece = points.piece[i];
    for (std::uint32_t n = 0; n < piece.count; ++n, ++k) {
      std::uint32_t& slot = scratch.slot[points.position[k]];
      if (slot == 0) {
        scratch.children.emplace_back(points.position[k]);
        slot = static_cast<std::uint32_t>(scratch.children.size());
      }
      scratch.children[slot - 1].chosen.add(mode, {points.x[k], points.y[k], points.z[k]}, points.C[k], piece.first + n,
                                            piece.camera);
    }
  }
}

/** \brief Splits a coarse cell: all of its points, some at a time. \param points FramePoints, or a PointArray */
template <typename Points>
void collect(Representatives mode, const CoarseGrid& grid, const CoarseGrid::Cell& cell, const CellSplit& split,
             const Points& points, CellScratch& scratch) {
  std::uint32_t r = cell.begin_run, done = 0;  // of that run
  // The next rows of the image, and the next camera's, are far away in memory; the runs of the next cell follow these.
  constexpr std::uint32_t runs_ahead = 6;
  std::uint32_t view = 0, view_ahead = 0;
  while (r < cell.end_run) {
    scratch.points.pieces = scratch.points.points = 0;
    inWideVectors([&] {
      while (r < cell.end_run) {
        const CoarseGrid::Stretch run = grid.runs()[r];
        const std::size_t room = CellPoints::kCapacity - scratch.points.points;
        if (room == 0) return;
        if (done == 0 && r + runs_ahead < grid.runs().size()) points.prefetch(grid.runs()[r + runs_ahead], view_ahead);
        const std::uint32_t left = run.count - done;
        done += points.read(split, run.begin + done, left < room ? left : static_cast<std::uint32_t>(room), view,
                            scratch.points);
        if (done < run.count) continue;
        ++r;
        done = 0;
      }
    });
    addToChildren(mode, scratch);
  }
}

/** \brief The cameras of a child's point. \param judged its number in scratch.judged, or of its first representative's
 *  \param asked whether other views were */
inline PointCameras camerasOf(const Child& child, bool each_judged, std::size_t judged, bool asked,
                              const CellOpinions& opinions) {
  PointCameras cameras;
  for (int k = 0; k < child.chosen.count(); ++k) cameras.addRepresentative(child.chosen[k].camera);
  if (asked)
    opinions.forEachNear(judged + static_cast<std::size_t>(each_judged ? child.chosen.main() : 0),
                         [&](std::uint32_t view) { cameras.addAgreeing(view); });
  return cameras;
}

/** \brief All of section 5 for one coarse cell; appends to scratch.output. Nothing here depends on the rest of the
 *  frame. \param points FramePoints, or a PointArray  \param crop_box points that views confirm outside of it are dropped */
template <typename Points>
void fuseCell(const AggregationParameters& p, int max_level, const CoarseGrid& grid, const CoarseGrid::Cell& cell,
              const Points& points, const ConsistencyEvaluator* evaluator, const Box& crop_box, CellScratch& scratch) {
  const int level = refinementLevel(cell.points, p.points_per_cell, max_level);
  const Vec3 corner = cellCorner(cell.key, p.cell_size);
  if (scratch.slot.size() < (std::size_t{1} << 3 * level)) scratch.slot.resize(std::size_t{1} << 3 * level, 0);
  scratch.children.clear();
  collect(p.representatives, grid, cell, {corner, level, childrenPerMetre(level, p.cell_size)}, points, scratch);
  measureConsistency(p.consistency_at, corner, p.cell_size, evaluator, scratch);
  const std::size_t children = scratch.children.size();
  scratch.fused.resize(children);
  scratch.omega.resize(children);
  const bool each = p.consistency_at == ConsistencyAt::Representatives;
  const float* V = scratch.V.data();
  const bool confirmed = !each && evaluator != nullptr && evaluator->knowsRefinedDepth();
  for (std::size_t k = 0; k < children; ++k) {
    const RepresentativeSelection& chosen = scratch.children[k].chosen;
    // In its place: a processor waits where memory is written in pieces and read as a whole.
    FusedPoint& fused = *::new (&scratch.fused[k]) FusedPoint(fuseRepresentatives(chosen, corner, each ? V : nullptr));
    scratch.omega[k] = fused.weight;
    if (!each) fused.weight *= *V;
    V += each ? chosen.count() : 1;
  }
  selectPoints(p, level, scratch);
  if (confirmed) readConfirmed(*evaluator, scratch);
  std::size_t share = 0, judged = 0;
  for (std::size_t k = 0; k < scratch.fused.size(); ++k) {
    const Child& child = scratch.children[k];
    const std::size_t first = judged;
    judged += each ? static_cast<std::size_t>(child.chosen.count()) : 1;
    if (!scratch.kept[k]) continue;
    FusedPoint& fused = scratch.fused[k];
    if (confirmed) {
      fused.p = evaluator->confirmed(fused.p, scratch.omega[k], scratch.opinions, k, scratch.confirmations, share);
      if (!crop_box.contains(fused.p)) continue;
    }
    const PointCameras cameras = camerasOf(child, each, first, evaluator != nullptr, scratch.opinions);
    fused.views = cameras.count();
    scratch.output.push_back(fused);
    scratch.output_cameras.push_back(cameras.mask());
  }
  for (const Child& child : scratch.children) scratch.slot[child.position] = 0;
}

/** \brief The fused points as they are. */
class FusedPointLists : public FusedPointSink {
 public:
  /** \brief Of one thread. */
  struct List {
    std::vector<FusedPoint> points;
    std::vector<std::uint64_t> cameras;  ///< PointCameras::mask() of each
  };

  void start(int threads) override { lists_.assign(static_cast<std::size_t>(threads), {}); }
  void add(int thread, const std::vector<FusedPoint>& points, const std::vector<std::uint64_t>& cameras) override {
    List& list = lists_[static_cast<std::size_t>(thread)];
    list.points.insert(list.points.end(), points.begin(), points.end());
    list.cameras.insert(list.cameras.end(), cameras.begin(), cameras.end());
  }
  void reserve(std::size_t) override {}

  /** \brief Those that a thread fused. */
  const List& operator[](int thread) const { return lists_[static_cast<std::size_t>(thread)]; }

 private:
  std::vector<List> lists_;
};

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
    parallelFor(threads, blocks, [&](std::size_t block, int thread) {
      CellScratch& s = scratch_[static_cast<std::size_t>(thread)];
      Block done{thread, fused_[static_cast<std::size_t>(thread)], 0, 0};
      const std::size_t end = std::min(cells.size(), (block + 1) * cells_per_block);
      for (std::size_t c = block * cells_per_block; c < end; ++c) {
        s.output.clear();
        s.output_cameras.clear();
        fuseCell(p, max_level, grid, cells[c], points, evaluator, crop_box, s);
        done.count += s.output.size();
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
    std::size_t children = 0, slots = 0, judged = 0, views = 0, confirmations = 0, rows = 0;
    for (const CellScratch& s : scratch_) {
      judged = std::max(judged, s.judged.capacity());
      children = std::max(children, s.children.capacity());
      slots = std::max(slots, s.slot.size());
      views = std::max(views, s.opinions.views());
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
  std::size_t total_{0};
};

}  // namespace host
}  // namespace fuse_flow
