#include "io/depth_in_range.h"

#include <fuse_flow/math/depth.h>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace fuse_flow::io {
namespace {

/** \brief Calls visit(metres) for each measurement, until it returns true. */
template <typename Pixel, typename Visit>
void forEachUntil(const ImageView<Pixel>& image, float scale, const Visit& visit) {
  for (int v = 0; v < image.height; ++v)
    for (int u = 0; u < image.width; ++u) {
      const Pixel raw = image.row(v)[u];
      const auto z = static_cast<float>(raw);
      const bool measured = std::isfinite(z) && z > 0 && (scale == 0 || z < 65535);
      if (measured && visit(scale == 0 ? z : scale * z)) return;
    }
}

}  // namespace

void DepthInRange::look(const RigFrame& frame) {
  cameras_.resize(frame.cameras.size());
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    Seen& seen = cameras_[i];
    const DepthView& view = frame.views[i];
    if (seen.in_range || view.missing()) continue;
    seen.name = frame.cameras[i].name;
    seen.images = true;
    seen.scale = view.depth16 ? frame.cameras[i].depth_scale : 0.0f;
    const auto visit = [&](float z) {
      seen.in_range = z >= range_.min_range && z <= range_.max_range;
      seen.nearest = seen.nearest > 0 ? std::min(seen.nearest, z) : z;
      seen.farthest = std::max(seen.farthest, z);
      return seen.in_range;
    };
    if (view.depth16) {
      forEachUntil(view.depth16, seen.scale, visit);
    } else {
      forEachUntil(view.depth32, 0, visit);
    }
  }
}

std::vector<std::string> DepthInRange::complaints() const {
  std::vector<std::string> lines;
  for (const Seen& seen : cameras_) {
    if (!seen.images || seen.in_range) continue;
    std::ostringstream line;
    line << "camera '" << seen.name << "' ";
    if (seen.farthest > 0) {
      line << "measures nothing within " << range_.min_range << " to " << range_.max_range << " m, but " << seen.nearest
           << " to " << seen.farthest << " m";
      if (seen.scale > 0) line << " with a depth_scale of " << seen.scale << " m";
    } else {
      line << "has images without any depth";
    }
    lines.push_back(line.str());
  }
  return lines;
}

}  // namespace fuse_flow::io
