#include "input_checks/noise_check.h"

#include <fuse_flow/math/noise_scale.h>

#include <sstream>

namespace fuse_flow::io {

void NoiseCheck::look(const RigFrame& frame, const FrameStatistics& statistics) {
  if (statistics.noise_scales.size() != frame.cameras.size()) return;
  cameras_.resize(frame.cameras.size());
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    if (!frame.cameras[i].noise || frame.views[i].missing()) continue;
    Seen& seen = cameras_[i];
    seen.name = frame.cameras[i].name;
    seen.model = *frame.cameras[i].noise;
    ++seen.images;
    seen.far_less += statistics.noise_scales[i] <= kMinNoiseScale ? 1 : 0;
    seen.far_more += statistics.noise_scales[i] >= kMaxNoiseScale ? 1 : 0;
  }
}

std::vector<std::string> NoiseCheck::complaints() const {
  std::vector<std::string> lines;
  for (const Seen& seen : cameras_) {
    const bool less = seen.far_less == seen.images, more = seen.far_more == seen.images;
    if (seen.images == 0 || !(less || more)) continue;
    std::ostringstream line;
    line << "camera '" << seen.name << "' has "
         << (less ? "less than a quarter of the noise" : "more than eight times the noise")
         << " that its own noise model says, and the bound is taken: " << 1000 * axialNoise(seen.model, 1)
         << " mm at 1 m; noise in rig.json must be in metres";
    lines.push_back(line.str());
  }
  return lines;
}

}  // namespace fuse_flow::io
