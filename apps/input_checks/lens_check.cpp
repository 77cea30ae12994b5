#include "input_checks/lens_check.h"

#include "input_checks/depth_at.h"

#include <fuse_flow/impl/sensors/rig_geometry.hpp>

#include <cstdio>

namespace fuse_flow::io {

void LensCheck::look(const RigFrame& frame) {
  cameras_.resize(frame.cameras.size());
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    Seen& seen = cameras_[i];
    const DepthView& view = frame.views[i];
    const Intrinsics& K = frame.cameras[i].intrinsics;
    if (seen.done || view.missing()) continue;
    seen.done = true;
    seen.name = frame.cameras[i].name;
    if (isIdeal(K.distortion)) continue;
    const host::RayFinder find(K);
    for (int v = 0; v < view.height(); ++v)
      for (int u = 0; u < view.width(); ++u) {
        if (!(depthAt(frame.cameras[i], view, u, v) > 0)) continue;
        ++seen.measured;
        seen.without_ray += find(static_cast<float>(u), static_cast<float>(v)).found ? 0 : 1;
      }
  }
}

std::vector<std::string> LensCheck::complaints() const {
  std::vector<std::string> lines;
  for (const Seen& seen : cameras_) {
    if (seen.without_ray == 0) continue;
    char share[32];
    std::snprintf(share, sizeof share, "%.1f",
                  100 * static_cast<double>(seen.without_ray) / static_cast<double>(seen.measured));
    lines.push_back("camera '" + seen.name + "': " + share +
                    " % of its measurements are left out: its lens model folds over, and has no ray for their pixels; "
                    "distortion must be of this lens, and of the model that distortion_model says");
  }
  return lines;
}

}  // namespace fuse_flow::io
