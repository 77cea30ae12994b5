#include "input_checks/lens_check.h"

#include "input_checks/depth_at.h"

#include <fuse_flow/impl/sensors/rig_geometry.hpp>

#include <cstdio>

namespace fuse_flow::io {

namespace {

/** \brief Share of an image's pixels, of which some are looked at, to which no ray belongs. */
double withoutRay(const Intrinsics& K) {
  if (isIdeal(K.distortion)) return 0;
  const host::RayFinder find(K);
  constexpr int step = 4;
  std::size_t pixels = 0, without = 0;
  for (int v = 0; v < K.height; v += step)
    for (int u = 0; u < K.width; u += step) {
      ++pixels;
      without += find(static_cast<float>(u), static_cast<float>(v)).found ? 0 : 1;
    }
  return pixels == 0 ? 0 : static_cast<double>(without) / static_cast<double>(pixels);
}

std::string percent(double share) {
  if (share < 0.0005) return "less than 0.1 %";
  char text[32];
  std::snprintf(text, sizeof text, "%.1f %%", 100 * share);
  return text;
}

constexpr double kWorthALine = 0.001;  // in the corners of images a right calibration folds over, too
constexpr const char* kRemedy = "distortion must be of this lens, and of the model that distortion_model says";

}  // namespace

void LensCheck::look(const RigFrame& frame) {
  cameras_.resize(frame.cameras.size());
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    Seen& seen = cameras_[i];
    const DepthView& view = frame.views[i];
    seen.name = frame.cameras[i].name;
    const Intrinsics& K = frame.cameras[i].intrinsics;
    const auto& color = frame.cameras[i].color;
    if (!seen.color_done && view.color && color) {
      seen.color_done = true;
      seen.color_without_ray = withoutRay(color->intrinsics);
    }
    if (seen.done || view.missing()) continue;
    seen.done = true;
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
    if (seen.without_ray > 0)
      lines.push_back(
          "camera '" + seen.name +
          "': " + percent(static_cast<double>(seen.without_ray) / static_cast<double>(seen.measured)) +
          " of its measurements are left out: its lens model folds over, and has no ray for their pixels; " + kRemedy);
    if (seen.color_without_ray >= kWorthALine)
      lines.push_back("camera '" + seen.name +
                      "': the lens model of its colour camera folds over, and has no ray for " +
                      percent(seen.color_without_ray) +
                      " of the pixels: points that they show have no colour of this camera; " + kRemedy);
  }
  return lines;
}

}  // namespace fuse_flow::io
