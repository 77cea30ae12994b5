#pragma once

#include <fuse_flow/impl/parameters.hpp>
#include <fuse_flow/math/stereo/matching_cost.h>
#include <fuse_flow/stereo/parameters.h>

namespace fuse_flow {

inline void checkParameters(const StereoParameters& p) {
  constexpr const char* owner = "fuse_flow::MultiViewStereo";
  detail::checkRange(owner, "max_sources", p.max_sources, 1, kMaxStereoSources);
  detail::checkRange(owner, "best_sources", p.best_sources, 1, kMaxBestViews);
  detail::checkNonNegative(owner, "min_depth", p.min_depth);
  detail::checkNonNegative(owner, "max_depth", p.max_depth);
  if (p.max_depth > 0 && p.max_depth <= p.min_depth)
    detail::throwBadArgument(owner, ": max_depth is ", p.max_depth, ", must exceed min_depth, ", p.min_depth);
  detail::checkRange(owner, "levels", p.levels, 1, kMaxStereoLevels);
  detail::checkPositive(owner, "sweep_step", p.sweep_step);
  detail::checkRange(owner, "sweep_step", p.sweep_step, 0.0f, 8.0f);
  detail::checkRange(owner, "max_planes", p.max_planes, 2, 1024);
  detail::checkRange(owner, "coarse_passes", p.coarse_passes, 1, 16);
  detail::checkRange(owner, "fine_passes", p.fine_passes, 0, 16);
  detail::checkRange(owner, "window_spacing", p.window_spacing, 1, 8);
  detail::checkPositive(owner, "level_sigma", p.level_sigma);
  detail::checkPositive(owner, "min_variance", p.min_variance);
  detail::checkNonNegative(owner, "geometric_weight", p.geometric_weight);
  detail::checkPositive(owner, "geometric_limit", p.geometric_limit);
  detail::checkNonNegative(owner, "min_incidence", p.min_incidence);
  detail::checkRange(owner, "min_incidence", p.min_incidence, 0.0f, 0.99f);
  detail::checkNonNegative(owner, "edge_step", p.edge_step);
  detail::checkRange(owner, "edge_step", p.edge_step, 0.0f, 0.99f);
  detail::checkRange(owner, "repetition_reach", p.repetition_reach, 0, 256);
}

}  // namespace fuse_flow
