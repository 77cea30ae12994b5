#pragma once

#include <fuse_flow/impl/fusion/cell_scratch.hpp>
#include <fuse_flow/math/adaptive_hash.h>

#include <algorithm>
#include <cstdint>

namespace fuse_flow {
namespace host {

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

}  // namespace host
}  // namespace fuse_flow
