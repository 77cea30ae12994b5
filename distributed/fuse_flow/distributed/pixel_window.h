#pragma once

#include <fuse_flow/impl/sensors/rig_geometry.hpp>
#include <fuse_flow/math/cell.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace fuse_flow {
namespace distributed {

/** \brief A rectangle of an image's pixels; right and bottom are not in it. */
struct PixelWindow {
  std::int32_t left{0}, top{0}, right{0}, bottom{0};

  FUSE_FLOW_HD bool empty() const { return left >= right || top >= bottom; }
  std::size_t width() const { return static_cast<std::size_t>(right - left); }
  std::size_t height() const { return static_cast<std::size_t>(bottom - top); }
  std::size_t pixels() const { return empty() ? 0 : width() * height(); }

  /** \brief The smallest that holds both. */
  void add(const PixelWindow& other) {
    if (other.empty()) return;
    *this = empty() ? other
                    : PixelWindow{std::min(left, other.left), std::min(top, other.top), std::max(right, other.right),
                                  std::max(bottom, other.bottom)};
  }
};

/** \brief Holds all points of the cells of a block. \param side of a block, metres */
FUSE_FLOW_HD host::Bounds blockBounds(std::uint64_t block, float side) {
  // Points lie in their cells within the rounding of floats.
  const float half = 0.5f * side * 1.001f;
  const Vec3 centre = cellCorner(block, side) + 0.5f * Vec3{side, side, side};
  const float rounding = 1e-5f * (std::fabs(centre.x) + std::fabs(centre.y) + std::fabs(centre.z));
  return {centre, {half + rounding, half + rounding, half + rounding}};
}

/** \brief Of x/z, or y/z, of rays. */
struct RayInterval {
  float low{INFINITY}, high{-INFINITY};
  FUSE_FLOW_HD void add(float value) {
    low = value < low ? value : low;
    high = value > high ? value : high;
  }
};

/** \brief Which pixels of a view see something of a box: from the rays of the pixels, whatever the lens, so that nothing has to be
 *  assumed of how a lens bends straight edges. Plain pointers, for the device too. */
struct BoxProjector {
  RigidTransform T_camera_world;
  int width, height;
  const RayInterval *columns, *rows;  ///< of kStrip of them each

  static constexpr int kStrip = 8;  ///< columns, or rows, that share an interval
  FUSE_FLOW_HD static int strips(int pixels) { return (pixels + kStrip - 1) / kStrip; }

  /** \brief Holds every pixel that a point of the box falls on, and as many around them. \param margin pixels */
  FUSE_FLOW_HD PixelWindow operator()(const host::Bounds& box, int margin) const {
    RayInterval x, y;
    bool before = false, behind = false;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 sign{corner & 1 ? 1.0f : -1.0f, corner & 2 ? 1.0f : -1.0f, corner & 4 ? 1.0f : -1.0f};
      const Vec3 p = T_camera_world * Vec3{box.centre.x + sign.x * box.half.x, box.centre.y + sign.y * box.half.y,
                                           box.centre.z + sign.z * box.half.z};
      constexpr float nearest = 1e-3f;  // metres; nearer there is no direction to speak of
      if (p.z <= nearest) {
        behind = true;
        continue;
      }
      before = true;
      x.add(p.x / p.z);
      y.add(p.y / p.z);
    }
    if (!before) return {};
    if (behind) return {0, 0, width, height};  // the camera is in it, or beside it
    PixelWindow window;
    reach(columns, x, width, margin, window.left, window.right);
    reach(rows, y, height, margin, window.top, window.bottom);
    return window.empty() ? PixelWindow{} : window;
  }

 private:
  FUSE_FLOW_HD static void reach(const RayInterval* strips_of, const RayInterval& box, int pixels, int margin,
                                 std::int32_t& begin, std::int32_t& end) {
    begin = pixels;
    end = 0;
    for (int s = 0; s < strips(pixels); ++s) {
      if (strips_of[s].high < box.low || strips_of[s].low > box.high) continue;
      const int from = s * kStrip - margin, to = s * kStrip + kStrip + margin;
      if (from < begin) begin = from > 0 ? from : 0;
      if (to > end) end = to < pixels ? to : pixels;
    }
  }
};

/** \brief A BoxProjector and what it points to. */
class BoxProjection {
 public:
  /** \param view whose rays are there */
  explicit BoxProjection(const host::ViewGeometry& view)
      : T_camera_world_(view.T_camera_world), width_(view.intrinsics.width), height_(view.intrinsics.height) {
    columns_.resize(strips(width_));
    rows_.resize(strips(height_));
    if (view.ideal) {
      for (int u = 0; u < width_; ++u) columns_[stripOf(u)].add(view.ray(u, 0).x);
      for (int v = 0; v < height_; ++v) rows_[stripOf(v)].add(view.ray(0, v).y);
    } else {
      for (int v = 0; v < height_; ++v)
        for (int u = 0; u < width_; ++u) {
          const Ray ray = view.ray(u, v);
          columns_[stripOf(u)].add(ray.x);
          rows_[stripOf(v)].add(ray.y);
        }
    }
    widen(columns_, 1.0f / view.intrinsics.fx);
    widen(rows_, 1.0f / view.intrinsics.fy);
  }

  BoxProjector projector() const { return {T_camera_world_, width_, height_, columns_.data(), rows_.data()}; }
  PixelWindow operator()(const host::Bounds& box, int margin) const { return projector()(box, margin); }
  const std::vector<RayInterval>& columns() const { return columns_; }
  const std::vector<RayInterval>& rows() const { return rows_; }

 private:
  static std::size_t strips(int pixels) { return static_cast<std::size_t>(BoxProjector::strips(pixels)); }
  static std::size_t stripOf(int pixel) { return static_cast<std::size_t>(pixel / BoxProjector::kStrip); }

  /** \brief A pixel reaches half a pixel beyond its ray; a whole one leaves room for rounding and for how lenses stretch. */
  static void widen(std::vector<RayInterval>& strips, float pixel) {
    for (RayInterval& strip : strips) {
      strip.low -= pixel;
      strip.high += pixel;
    }
  }

  RigidTransform T_camera_world_;
  int width_, height_;
  std::vector<RayInterval> columns_, rows_;
};

}  // namespace distributed
}  // namespace fuse_flow
