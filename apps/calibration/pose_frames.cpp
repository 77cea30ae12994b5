#include "calibration/pose_frames.h"

#include <fuse_flow/impl/sensors/depth_map.hpp>
#include <fuse_flow/impl/sensors/preprocessing.hpp>

#include <algorithm>

namespace fuse_flow::io {
namespace {

constexpr std::size_t kManyFrames = 40;

/** \brief Whether neighbouring pixels of the view err together, as pose estimation sees it. */
bool isCoarse(const Camera& camera, const DepthView& view, const ExtrinsicParameters& parameters) {
  host::ViewGeometry geometry;
  geometry.assign(camera);
  host::DepthMap depth;
  host::makeDepthMap(parameters.preprocessing, geometry, view, depth);
  ViewNoise noise = viewNoise(noiseParameters(parameters), geometry.ownNoise());
  noise.scale = host::measureNoiseScale(noise.model, depth);
  return blockReduction(parameters, depth.width(), noise.level()) > parameters.reduction;
}

}  // namespace

std::vector<std::size_t> spreadFrames(std::size_t most, std::size_t count) {
  std::vector<std::size_t> frames;
  const std::size_t n = std::min(most, count);
  for (std::size_t k = 0; k < n; ++k) frames.push_back(k * count / n);
  return frames;
}

std::size_t enoughFrames(const RigFrame& frame, const ExtrinsicParameters& parameters) {
  for (std::size_t i = 0; i < frame.views.size(); ++i)
    if (!frame.views[i].missing() && isCoarse(frame.cameras[i], frame.views[i], parameters)) return kManyFrames;
  return kFewFrames;
}

std::vector<std::size_t> framesForPoses(Recording& recording, const ExtrinsicParameters& parameters) {
  const std::vector<std::size_t> all = recording.frames();
  const auto spread = [&](std::size_t most) {
    std::vector<std::size_t> chosen = spreadFrames(most, all.size());
    for (std::size_t& frame : chosen) frame = all[frame];
    return chosen;
  };
  const std::vector<std::size_t> few = spread(kFewFrames);
  if (few.size() == all.size()) return few;
  std::vector<char> seen(recording.cameras().size(), 0);
  LoadedFrame loaded;
  for (const std::size_t frame : few) {
    recording.read(frame, loaded);
    const std::size_t enough = enoughFrames(loaded.rig, parameters);
    if (enough > few.size()) return spread(enough);
    for (std::size_t i = 0; i < seen.size(); ++i) seen[i] |= !loaded.rig.views[i].missing();
    if (std::count(seen.begin(), seen.end(), 0) == 0) break;
  }
  return few;
}

}  // namespace fuse_flow::io
