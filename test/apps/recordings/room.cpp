#include "room.h"

#include "../tools/support/png_file.h"

#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <sstream>

namespace io_test {
namespace {

using Eigen::Vector3d;

struct Wall {
  int axis;
  double place;
  Rgb8 color;
};
constexpr std::array<Wall, 6> kWalls{{{0, -1.5, {200, 0, 0}},
                                      {0, 2.5, {0, 200, 0}},
                                      {1, -2.0, {0, 0, 200}},
                                      {1, 1.8, {200, 200, 0}},
                                      {2, 0.0, {0, 200, 200}},
                                      {2, 2.6, {200, 0, 200}}}};

struct Meeting {
  double depth;
  const Wall* wall;
};

/** \brief Where the ray of a pixel leaves the room. */
Meeting meet(const RoomView& view, int u, int v) {
  const Vector3d origin = view.T_world_camera.translation();
  const Vector3d ray = view.T_world_camera.linear() * Vector3d((u - view.cx) / view.fx, (v - view.cy) / view.fy, 1);
  Meeting nearest{std::numeric_limits<double>::infinity(), nullptr};
  for (const Wall& wall : kWalls) {
    const double depth = (wall.place - origin[wall.axis]) / ray[wall.axis];
    if (depth > 0 && depth < nearest.depth) nearest = {depth, &wall};
  }
  return nearest;
}

RoomView lookAt(const Vector3d& eye, const Vector3d& target) {
  const Vector3d forward = (target - eye).normalized();
  const Vector3d right = forward.cross(Vector3d::UnitZ()).normalized();
  RoomView view;
  view.T_world_camera.linear() << right, forward.cross(right), forward;
  view.T_world_camera.translation() = eye;
  return view;
}

/** \brief NaN where there is none. */
double measuredDepth(const Camera& camera, const DepthView& view, int u, int v) {
  if (view.depth32) return view.depth32.row(v)[u];
  const std::uint16_t units = view.depth16.row(v)[u];
  return units == 0 || units == 65535 ? std::nan("") : units * static_cast<double>(camera.depth_scale);
}

bool sameColor(const Rgb8& a, const Rgb8& b) { return a.r == b.r && a.g == b.g && a.b == b.b; }

/** \brief A wall within 2 mm of the point, of this colour if there is one. */
const Wall* wallAt(const Vector3d& p_W, const Rgb8* color) {
  for (const Wall& wall : kWalls)
    if (std::abs(p_W[wall.axis] - wall.place) < 0.002 && (!color || sameColor(*color, wall.color))) return &wall;
  return nullptr;
}

}  // namespace

double RoomView::depth(int u, int v) const { return meet(*this, u, v).depth; }

Eigen::Vector3d RoomView::point(int u, int v) const { return depth(u, v) * Vector3d((u - cx) / fx, (v - cy) / fy, 1); }

Rgb8 RoomView::color(int u, int v) const { return meet(*this, u, v).wall->color; }

std::string RoomView::depthPng(double metres_per_unit) const {
  std::vector<std::uint16_t> pixels;
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u)
      pixels.push_back(static_cast<std::uint16_t>(std::lround(depth(u, v) / metres_per_unit)));
  return tool_test::depthPng(width, height, pixels);
}

std::string RoomView::colorPng() const {
  std::string samples;
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) {
      const Rgb8 c = color(u, v);
      samples += {static_cast<char>(c.r), static_cast<char>(c.g), static_cast<char>(c.b)};
    }
  return tool_test::samplesPng(width, height, 8, 2, samples);
}

std::string RoomView::poseText() const {
  std::ostringstream text;
  text.precision(17);
  text << T_world_camera.matrix() << '\n';
  return text.str();
}

RoomView levelView() {
  RoomView view;
  view.T_world_camera.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  view.T_world_camera.translation() << 0.5, 0.3, 1.2;
  return view;
}

RoomView cornerView(int step) { return lookAt({0.2, -0.4 + 0.1 * step, 1.3}, {2.5, 1.8, 0.2}); }

testing::AssertionResult showsRoom(const io::LoadedFrame& frame, std::size_t view, std::size_t walls) {
  const DepthView& images = frame.rig.views.at(view);
  if (images.missing()) return testing::AssertionFailure() << "the view is missing";
  const Camera& camera = frame.rig.cameras.at(view);
  const Intrinsics& K = camera.intrinsics;
  std::set<const Wall*> seen;
  int valid = 0;
  for (int v = 0; v < K.height; ++v)
    for (int u = 0; u < K.width; ++u) {
      const double z = measuredDepth(camera, images, u, v);
      if (!std::isfinite(z)) continue;
      const Vector3d p_W = camera.T_world_camera * Vector3d((u - K.cx) / K.fx * z, (v - K.cy) / K.fy * z, z);
      const Wall* wall = wallAt(p_W, images.color ? &images.color.row(v)[u] : nullptr);
      if (!wall)
        return testing::AssertionFailure() << "pixel " << u << ", " << v << " at depth " << z << " is at "
                                           << p_W.transpose() << ", on no wall of its colour";
      seen.insert(wall);
      ++valid;
    }
  if (valid < 9 * K.width * K.height / 10) return testing::AssertionFailure() << "only " << valid << " valid pixels";
  if (seen.size() < walls) return testing::AssertionFailure() << "only " << seen.size() << " walls are seen";
  return testing::AssertionSuccess();
}

}  // namespace io_test
