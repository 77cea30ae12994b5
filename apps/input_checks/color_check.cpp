#include "input_checks/color_check.h"

#include "input_checks/depth_at.h"

#include <fuse_flow/impl/sensors/rig_geometry.hpp>
#include <fuse_flow/math/confidence.h>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace fuse_flow::io {
namespace {

/** \brief Whether the colour image shows any of the points of a grid over the depth image. */
bool anyInImage(const Camera& camera, const DepthView& view) {
  host::ViewGeometry geometry;
  geometry.assign(camera);
  const int step = std::max(1, std::max(view.width(), view.height()) / 64);
  for (int v = 0; v < view.height(); v += step)
    for (int u = 0; u < view.width(); u += step) {
      const float z = depthAt(camera, view, u, v);
      if (z > 0 && viewColor(geometry, view.color, {}, u, v, geometry.ray(u, v), z).known) return true;
    }
  return false;
}

}  // namespace

void ColorCheck::look(const RigFrame& frame) {
  cameras_.resize(frame.cameras.size());
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    const DepthView& view = frame.views[i];
    if (view.missing()) continue;
    Seen& seen = cameras_[i];
    seen.name = frame.cameras[i].name;
    ++seen.frames;
    if (!view.color) continue;
    ++seen.colored;
    if (!frame.cameras[i].color || seen.any_in_image) continue;
    seen.own_camera = true;
    seen.baseline = frame.cameras[i].color->T_depth_color.translation().norm();
    seen.any_in_image = anyInImage(frame.cameras[i], view);
  }
}

std::vector<std::string> ColorCheck::complaints() const {
  std::vector<std::string> lines;
  if (std::none_of(cameras_.begin(), cameras_.end(), [](const Seen& seen) { return seen.colored > 0; })) return lines;
  for (const Seen& seen : cameras_) {
    std::ostringstream line;
    line << "camera '" << seen.name << "' ";
    if (seen.colored < seen.frames) {
      line << "has no colour in " << seen.frames - seen.colored << " of " << seen.frames
           << " frames: what only it measured is black there";
      lines.push_back(line.str());
    } else if (seen.own_camera && !seen.any_in_image) {
      line << "has colour images into which none of its points falls: T_depth_color is " << seen.baseline
           << " m long, must be the colour camera's pose in the depth camera's frame, in metres";
      lines.push_back(line.str());
    }
  }
  return lines;
}

void ConfidenceCheck::look(const LoadedFrame& frame, const std::vector<bool>& estimated) {
  cameras_.resize(frame.rig.cameras.size());
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    Seen& seen = cameras_[i];
    const Camera& camera = frame.rig.cameras[i];
    const DepthView& view = frame.rig.views[i];
    if (!view.confidence || view.missing() || (!estimated.empty() && estimated[i])) continue;
    seen.name = camera.name;
    seen.step = frame.images[i].assumed_confidence_step;
    for (int v = 0; v < view.height(); ++v)
      for (int u = 0; u < view.width(); ++u) {
        const float given = view.confidence.row(v)[u];
        seen.largest = std::max(seen.largest, given);
        if (!(depthAt(camera, view, u, v) > 0)) continue;
        ++seen.measured;
        if (!min_confidence_) continue;
        seen.dropped += givenWeight(given, *min_confidence_) > 0 ? 0 : 1;
        seen.under_tau += tau_ && givenWeight(given, *min_confidence_) > 0 && !(givenConfidence(given) > *tau_) ? 1 : 0;
      }
  }
}

std::vector<std::string> ConfidenceCheck::complaints() const {
  std::vector<std::string> lines;
  for (const Seen& seen : cameras_) {
    std::ostringstream line;
    line << "camera '" << seen.name << "' has ";
    if (seen.step > 0 && seen.largest < 0.5f) {
      const long largest = std::lround(seen.largest / seen.step), most = std::lround(1 / seen.step);
      line << largest << " as the largest value of its confidence images, of " << most
           << ", so that it is never surer than " << seen.largest;
      if (largest > 0)
        line << "; if " << largest << " means certain, confidence_scale in rig.json must be "
             << 1.0 / static_cast<double>(largest);
    } else if (2 * seen.dropped > seen.measured) {
      line << std::lround(100.0 * static_cast<double>(seen.dropped) / static_cast<double>(seen.measured))
           << " % of its measurements dropped: their confidence is ";
      if (*min_confidence_ > 0) {
        line << "below --min-confidence " << *min_confidence_;
      } else {
        line << "0";
      }
    } else if (2 * (seen.dropped + seen.under_tau) > seen.measured) {
      line << std::lround(100.0 * static_cast<double>(seen.under_tau) / static_cast<double>(seen.measured))
           << " % of its measurements dropped: their confidence, which is C of eq. 9, is not over --tau " << *tau_;
    } else {
      continue;
    }
    lines.push_back(line.str());
  }
  return lines;
}

}  // namespace fuse_flow::io
