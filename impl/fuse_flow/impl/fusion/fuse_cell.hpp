#pragma once

#include <fuse_flow/impl/fusion/cell_scratch.hpp>
#include <fuse_flow/impl/fusion/coarse_grid.hpp>
#include <fuse_flow/impl/fusion/consistency_evaluator.hpp>
#include <fuse_flow/impl/fusion/select_points.hpp>
#include <fuse_flow/math/adaptive_hash.h>
#include <fuse_flow/math/box.h>
#include <fuse_flow/math/representatives.h>

#include <cstddef>
#include <cstdint>
#include <new>

namespace fuse_flow {
namespace host {

/** \brief Hands the points that were read to the children they fall into. */
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

/** \brief Section 5 (2) a: splits a coarse cell into children, and finds the representatives of each: all of its points, some at a time. \param points FramePoints, or a PointArray */
template <typename Points>
void chooseRepresentatives(Representatives mode, const CoarseGrid& grid, const CoarseGrid::Cell& cell,
                           const CellSplit& split, const Points& points, CellScratch& scratch) {
  if (scratch.slot.size() < (std::size_t{1} << 3 * split.level))
    scratch.slot.resize(std::size_t{1} << 3 * split.level, 0);
  scratch.children.clear();
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
  for (const Child& child : scratch.children) scratch.slot[child.position] = 0;
}

/** \brief Section 5 (2) b: V of every representative, or of every cell's mean, child after child; and what other views
 *  confirm there. A mean's surface faces as that of its highest-ranking representative. */
template <typename Points>
void measureConsistency(ConsistencyAt at, const Vec3& corner, float cell_size, const Points& points,
                        const ConsistencyEvaluator* evaluator, CellScratch& scratch) {
  const std::size_t per_child = at == ConsistencyAt::CellMean ? 1 : kRepresentatives;
  scratch.judged.resize(per_child * scratch.children.size());
  scratch.judged_camera.resize(scratch.judged.size());
  const bool with_normals = Points::kHasNormals && evaluator != nullptr && evaluator->asksForNormals();
  scratch.normals.clear();
  if (with_normals) scratch.normals.reserve(scratch.judged.size());
  std::size_t n = 0;
  for (Child& child : scratch.children) {
    child.chosen.finish();
    if (at == ConsistencyAt::CellMean) {
      const Candidate main = child.chosen[child.chosen.main()];
      scratch.judged[n] = corner + child.chosen.mean();
      if (with_normals) points.addNormal(main.best, main.camera, scratch.normals);
      scratch.judged_camera[n++] = main.camera;
    } else {
      for (int k = 0; k < child.chosen.count(); ++k) {
        const Candidate c = child.chosen[k];
        scratch.judged[n] = corner + (1.0f / c.sum_C) * c.sum;
        if (with_normals) points.addNormal(c.best, c.camera, scratch.normals);
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
  if (with_normals) scratch.normals.compute();
  evaluator->evaluate(cell, scratch.judged.data(), with_normals ? &scratch.normals : nullptr,
                      scratch.judged_camera.data(), scratch.judged.size(), scratch.opinions, scratch.V.data());
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

/** \brief Eq. 10 and 11: the mean of each child's representatives, weighed by C, or by C V. */
inline void fuseChildren(ConsistencyAt at, const Vec3& corner, CellScratch& scratch) {
  const std::size_t children = scratch.children.size();
  scratch.fused.resize(children);
  scratch.omega.resize(children);
  const bool each = at == ConsistencyAt::Representatives;
  const float* V = scratch.V.data();
  for (std::size_t k = 0; k < children; ++k) {
    const RepresentativeSelection& chosen = scratch.children[k].chosen;
    // In its place: a processor waits where memory is written in pieces and read as a whole.
    FusedPoint& fused = *::new (&scratch.fused[k]) FusedPoint(fuseRepresentatives(chosen, corner, each ? V : nullptr));
    scratch.omega[k] = fused.weight;
    if (!each) fused.weight *= *V;
    V += each ? chosen.count() : 1;
  }
}

/** \brief Hands out the points that stay, where the views confirm them, with their cameras. \param evaluator null: no other view was asked
 *  \param crop_box points that views confirm outside of it are dropped */
inline void writePoints(ConsistencyAt at, const ConsistencyEvaluator* evaluator, const Box& crop_box,
                        CellScratch& scratch) {
  const bool each = at == ConsistencyAt::Representatives;
  const bool confirmed = !each && evaluator != nullptr && evaluator->knowsRefinedDepth();
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
}

/** \brief All of section 5 (2) for one coarse cell; appends to scratch.output. Nothing here depends on the rest of the
 *  frame. \param points FramePoints, or a PointArray  \param crop_box points that views confirm outside of it are dropped */
template <typename Points>
void fuseCell(const AggregationParameters& p, int max_level, const CoarseGrid& grid, const CoarseGrid::Cell& cell,
              const Points& points, const ConsistencyEvaluator* evaluator, const Box& crop_box, CellScratch& scratch) {
  const int level = refinementLevel(cell.points, p.points_per_cell, max_level);
  const Vec3 corner = cellCorner(cell.key, p.cell_size);
  chooseRepresentatives(p.representatives, grid, cell, {corner, level, childrenPerMetre(level, p.cell_size)}, points,
                        scratch);
  measureConsistency(p.consistency_at, corner, p.cell_size, points, evaluator, scratch);
  fuseChildren(p.consistency_at, corner, scratch);
  selectPoints(p, level, scratch);
  writePoints(p.consistency_at, evaluator, crop_box, scratch);
}

}  // namespace host
}  // namespace fuse_flow
