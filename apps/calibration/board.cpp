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

Board::Board(const BoardKind& kind) : kind_(kind) {
  checkBoard(kind);
  detector_ = makeBoardDetector(kind);
}

void Board::addFrame(const LoadedFrame& frame) {
  for (std::size_t i = 0; i < frame.images.size(); ++i) {
    if (!frame.rig.views[i].color) continue;
    color_ = true;
    for (DetectedBoard& found : detector_->detect(frame.images[i].color)) {
      const float depth = measuredDepth(frame.rig.views[i], frame.rig.cameras[i], found.middle.pixel);
      sightings_.push_back({i, frames_, found.id, std::move(found.points), depth, found.middle.place});
    }
  }
  ++frames_;
}

MarkerRig Board::place(const std::vector<Camera>& cameras) const {
  if (!color_) throw InputError("--board: the recording has no colour images");
  MarkerRig rig = placeByMarkers(cameras, sightings_);
  std::string lost;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    bool saw = false;
    for (const MarkerSighting& sighting : sightings_) saw = saw || sighting.camera == i;
    if (rig.placed[i] && saw) continue;
    const char* why = isOne() ? (saw ? "' never saw it together with the others" : "' never saw it")
                              : (saw ? "' saw none together with the others" : "' saw none");
    lost += (lost.empty() ? "'" : ", '") + cameras[i].name + why;
  }
  if (!lost.empty()) {
    const std::string advice = detector_->advice();
    throw InputError(std::string("--board: ") + (isOne() ? "the board does" : "markers do") +
                     " not connect every camera with the first: " + lost +
                     "; show one to two cameras at a time until all are linked" +
                     (advice.empty() ? "" : "; " + advice));
  }
  if (rig.residual > kContradiction)
    throw InputError(std::string("--board: corners of ") + (isOne() ? "the board" : "markers") + " are " +
                     number("%.1f", rig.residual) +
                     " pixels from where they should be; were the cameras not synchronised while it moved?");
  if (rig.depth_ratio > 0 && std::fabs(rig.depth_ratio - 1) > kWrongSize)
    throw InputError(std::string("--board: ") + (isOne() ? "squares" : "markers") + " of " + number("%g", kind_.side) +
                     " m would lie elsewhere than depth was measured; by depth " + "their side is about " +
                     number("%.2g", kind_.side * rig.depth_ratio) + " m");
  return rig;
}

std::string Board::summary(const MarkerRig& rig) const {
  const std::string count = std::to_string(rig.markers),
                    corners = " corners fit to " + number("%.2f", rig.residual) + " pixels.\n";
  std::string text = isOne() ? "Poses found from " + count + " places of the board that several cameras saw;" + corners
                             : "Poses found from " + count + " markers that several cameras saw;" + corners;
  const std::string assumption = assumptionAbout(kind_);
  if (!assumption.empty()) text += assumption + "\n";
  if (rig.depth_ratio == 0)
    text += "No depth was measured on it: its size, and so all distances, are as --board says.\n";
  if (rig.unusable > 0) text += std::to_string(rig.unusable) + " sightings are left out: their points give no pose.\n";
  return text;
}

}  // namespace fuse_flow::io
