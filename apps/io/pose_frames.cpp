#include "io/pose_frames.h"

#include <fuse_flow/impl/host/depth_map.hpp>

#include <algorithm>

namespace fuse_flow::io {
namespace {

constexpr std::size_t kFrames = 10, kCoarseFrames = 40;

/** \brief Whether neighbouring pixels of the view err together, as pose estimation sees it. */
bool isCoarse(const Camera& camera, const DepthView& view, const ExtrinsicParameters& parameters) {
  host::ViewGeometry geometry;
  geometry.assign(camera);
  host::DepthMap depth;
  host::makeDepthMap(parameters.preprocessing, geometry, view, depth);
  const float noise_scale = host::measureNoiseScale(parameters.noise, depth);
  return blockReduction(parameters, depth.width(), noise_scale) > parameters.reduction;
}

}  // namespace

std::vector<std::size_t> spreadFrames(std::size_t most, std::size_t count) {
  std::vector<std::size_t> frames;
  const std::size_t n = std::min(most, count);
  for (std::size_t k = 0; k < n; ++k) frames.push_back(k * count / n);
  return frames;
}

std::vector<std::size_t> framesForPoses(Recording& recording, const ExtrinsicParameters& parameters) {
  const std::vector<std::size_t> few = spreadFrames(kFrames, recording.frameCount());
  if (few.size() == recording.frameCount()) return few;
  std::vector<char> seen(recording.cameras().size(), 0);
  LoadedFrame loaded;
  for (const std::size_t frame : few) {
    if (std::count(seen.begin(), seen.end(), 0) == 0) break;
    recording.read(frame, loaded);
    for (std::size_t i = 0; i < seen.size(); ++i) {
      if (seen[i] || loaded.rig.views[i].missing()) continue;
      if (isCoarse(loaded.rig.cameras[i], loaded.rig.views[i], parameters))
        return spreadFrames(kCoarseFrames, recording.frameCount());
      seen[i] = 1;
    }
  }
  return few;
}

}  // namespace fuse_flow::io
