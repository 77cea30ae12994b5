#include "calibration/board.h"

#include <fuse_flow/recordings/error.h>

#include <cmath>
#include <cstdio>

namespace fuse_flow::io {
namespace {

/** \brief Largest distance of corners from where they should be, root mean square, pixels. */
constexpr double kContradiction = 3;
/** \brief Share by which depth may differ from what the size of the markers says. */
constexpr double kWrongSize = 0.08;

/** \brief Where the diagonals cross: the middle of the square, seen from anywhere. */
Pixel middle(const std::array<Pixel, 4>& c) {
  const float ax = c[2].u - c[0].u, ay = c[2].v - c[0].v, bx = c[3].u - c[1].u, by = c[3].v - c[1].v;
  const float determinant = ax * by - ay * bx;
  const float t = ((c[1].u - c[0].u) * by - (c[1].v - c[0].v) * bx) / determinant;
  return {c[0].u + t * ax, c[0].v + t * ay};
}

/** \brief Metres; 0: not measured, or the colour image is not registered to depth. */
float measuredDepth(const DepthView& view, const Camera& camera, const Pixel& at) {
  const int u = static_cast<int>(std::lround(at.u)), v = static_cast<int>(std::lround(at.v));
  const Intrinsics& K = camera.intrinsics;
  if (camera.color || view.missing() || u < 0 || v < 0 || u >= K.width || v >= K.height) return 0;
  const float z =
      view.depth32 ? view.depth32.row(v)[u] : camera.depth_scale * static_cast<float>(view.depth16.row(v)[u]);
  return std::isfinite(z) && z > 0 && z < 60 ? z : 0;
}

std::string number(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

}  // namespace

void Board::addFrame(const LoadedFrame& frame) {
  for (std::size_t i = 0; i < frame.images.size(); ++i) {
    if (!frame.rig.views[i].color) continue;
    color_ = true;
    for (const DetectedMarker& marker : detector_.detect(frame.images[i].color)) {
      const float depth = measuredDepth(frame.rig.views[i], frame.rig.cameras[i], middle(marker.corners));
      sightings_.push_back({i, frames_, marker.id, marker.corners, depth});
    }
  }
  ++frames_;
}

MarkerRig Board::place(const std::vector<Camera>& cameras) const {
  if (!color_) throw InputError("--board: the recording has no colour images");
  MarkerRig rig = placeByMarkers(cameras, sightings_, side_);
  std::string lost;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    bool saw = false;
    for (const MarkerSighting& sighting : sightings_) saw = saw || sighting.camera == i;
    if (rig.placed[i] && saw) continue;
    lost +=
        (lost.empty() ? "'" : ", '") + cameras[i].name + (saw ? "' saw none together with the others" : "' saw none");
  }
  if (!lost.empty())
    throw InputError("--board: markers do not connect every camera with the first: " + lost +
                     "; show one to two cameras at a time until all are linked");
  if (rig.residual > kContradiction)
    throw InputError("--board: corners of markers are " + number("%.1f", rig.residual) +
                     " pixels from where they should be; were the cameras not synchronised while it moved?");
  if (rig.depth_ratio > 0 && std::fabs(rig.depth_ratio - 1) > kWrongSize)
    throw InputError("--board: markers of " + number("%g", side_) +
                     " m would lie elsewhere than depth was measured; by depth " + "their side is about " +
                     number("%.2g", side_ * rig.depth_ratio) + " m");
  return rig;
}

}  // namespace fuse_flow::io
