#pragma once

#include "fuzz_target.h"

#include "../gpu/random_rig.h"

#include <fuse_flow/fuse_flow.h>
#include <fuse_flow/point_types.h>

#include <pcl/exceptions.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <string>

namespace fuse_flow_fuzz {

constexpr int kMostCameras = 5, kLargestSide = 24;

/** \brief A frame, at times one that must be refused. */
inline void drawFrame(random_rig::Random& random, random_rig::RandomFrame& frame) {
  frame.draw(random, kMostCameras, kLargestSide);
  if (!random.oneIn(8)) return;
  const auto at = static_cast<std::size_t>(random.below(static_cast<int>(frame.rig.cameras.size())));
  fuse_flow::Camera& camera = frame.rig.cameras[at];
  fuse_flow::DepthView& view = frame.rig.views[at];
  switch (random.below(9)) {
    case 0:
      camera.intrinsics.fx = random.oneIn(2) ? 0.0f : std::numeric_limits<float>::quiet_NaN();
      break;
    case 1:
      camera.intrinsics.width += 1;
      break;
    case 2:
      camera.T_world_camera.linear() *= random.uniform(-2.0, 2.0);
      break;
    case 3:
      camera.T_world_camera.translation().x() = random.oneIn(2) ? 1e30 : 1e7;
      break;
    case 4:
      camera.depth_scale = random.uniform(-1.0f, 0.0f);
      break;
    case 5:
      frame.rig.views.pop_back();
      break;
    case 6:
      view.color.height -= 1;
      break;
    case 7:
      camera.intrinsics.distortion.k1 = random.uniform(-1e6f, 1e6f);
      break;
    default:
      frame.rig.cameras.clear();
      frame.rig.views.clear();
  }
}

/** \brief Parameters, at times with one that must be refused, or that is at the end of its range. */
inline fuse_flow::FuseFlowParameters drawParameters(random_rig::Random& random, int cameras) {
  fuse_flow::FuseFlowParameters p = random_rig::parameters(random, 1.5, std::max(1, cameras));
  if (!random.oneIn(6)) return p;
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInfinity = std::numeric_limits<float>::infinity();
  const float values[] = {0, -1, 1, 1e-30f, 1e30f, kNan, kInfinity, -kInfinity};
  const float value = values[random.below(8)];
  switch (random.below(14)) {
    case 0:
      p.preprocessing.min_range = value;
      break;
    case 1:
      p.preprocessing.max_range = value;
      break;
    case 2:
      p.smoothing.tolerance = value;
      break;
    case 3:
      p.half_weight_noise = value;
      break;
    case 4:
      p.confidence.length_unit = value;
      break;
    case 5:
      p.confidence.beta = value;
      break;
    case 6:
      p.confidence.noise.quadratic = value;
      break;
    case 7:
      p.consistency.sigma = value;
      break;
    case 8:
      p.consistency.margin = value;
      break;
    case 9:
      p.aggregation.points_per_cell = value;
      break;
    case 10:
      p.aggregation.min_weight = value;
      break;
    case 11:
      p.aggregation.min_cell_size = value;
      break;
    case 12:
      p.agreement.min_views = random.below(70) - 2;
      break;
    default:
      p.aggregation.reach_per_noise = value;
  }
  return p;
}

/** \brief What a call says as it refuses; absent: it does not. */
template <typename Action>
std::optional<std::string> refusalOf(const Action& action) {
  try {
    action();
    return std::nullopt;
  } catch (const pcl::PCLException& error) {
    return error.what();
  }
}

}  // namespace fuse_flow_fuzz
