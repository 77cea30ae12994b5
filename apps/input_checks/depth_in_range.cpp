#include "input_checks/depth_in_range.h"

#include <fuse_flow/impl/sensors/depth_map.hpp>

#include <algorithm>
#include <sstream>

namespace fuse_flow::io {
namespace {

void add(const DepthOutOfRange& image, DepthOutOfRange& sum) {
  if (image.measured == 0) return;
  sum.nearest = sum.measured == 0 ? image.nearest : std::min(sum.nearest, image.nearest);
  sum.farthest = std::max(sum.farthest, image.farthest);
  sum.measured += image.measured;
  sum.in_range += image.in_range;
}

}  // namespace

void DepthInRange::look(const RigFrame& frame) {
  cameras_.resize(frame.cameras.size());
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    Seen& seen = cameras_[i];
    const DepthView& view = frame.views[i];
    if (seen.right || view.missing()) continue;
    seen.name = frame.cameras[i].name;
    seen.images = true;
    seen.scale = view.depth16 ? frame.cameras[i].depth_scale : 0.0f;
    const DepthOutOfRange image = host::depthOutOfRange(view, frame.cameras[i].depth_scale, i, range_);
    seen.right = image.measured > 0 && !host::nearlyAll(image);
    add(image, seen.depth);
  }
}

std::vector<std::string> DepthInRange::complaints() const {
  std::vector<std::string> lines;
  for (const Seen& seen : cameras_) {
    if (!seen.images || seen.right) continue;
    const DepthOutOfRange& depth = seen.depth;
    std::ostringstream line;
    line << "camera '" << seen.name << "' ";
    if (depth.measured > 0) {
      line << "measures ";
      if (depth.in_range > 0) {
        line << "only " << depth.in_range << " of " << depth.measured << " pixels";
      } else {
        line << "nothing";
      }
      line << " within " << range_.min_range << " to " << range_.max_range << " m, but " << depth.nearest << " to "
           << depth.farthest << " m";
      if (seen.scale > 0)
        line << " with a depth_scale of " << seen.scale << " m";
      else
        line << "; depth in float is metres";
    } else {
      line << "has images without any depth";
    }
    lines.push_back(line.str());
  }
  return lines;
}

}  // namespace fuse_flow::io
