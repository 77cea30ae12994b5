#pragma once

#include <fuse_flow/impl/sensors/rig_geometry.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace fuse_flow {
namespace distributed {

/** \brief A rectangle of an image's pixels; right and bottom are not in it. */
struct PixelWindow {
  std::int32_t left{0}, top{0}, right{0}, bottom{0};

  bool empty() const { return left >= right || top >= bottom; }
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

/** \brief Which pixels of a view see something of a box: from the rays of the pixels, whatever the lens, so that nothing has to be
 *  assumed of how a lens bends straight edges. */
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

  /** \brief Holds every pixel that a point of the box falls on, and as many around them. \param margin pixels */
  PixelWindow operator()(const host::Bounds& box, int margin) const {
    Interval x, y;
    bool before = false, behind = false;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 sign{corner & 1 ? 1.0f : -1.0f, corner & 2 ? 1.0f : -1.0f, corner & 4 ? 1.0f : -1.0f};
      const Vec3 p = T_camera_world_ * Vec3{box.centre.x + sign.x * box.half.x, box.centre.y + sign.y * box.half.y,
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
    if (behind) return {0, 0, width_, height_};  // the camera is in it, or beside it
    PixelWindow window;
    reach(columns_, x, width_, margin, window.left, window.right);
    reach(rows_, y, height_, margin, window.top, window.bottom);
    return window.empty() ? PixelWindow{} : window;
  }

 private:
  /** \brief Of x/z, or y/z, of rays. */
  struct Interval {
    float low{INFINITY}, high{-INFINITY};
    void add(float value) {
      low = std::min(low, value);
      high = std::max(high, value);
    }
  };

  static constexpr int kStrip = 8;  ///< columns, or rows, that share an interval
  static std::size_t strips(int pixels) { return static_cast<std::size_t>((pixels + kStrip - 1) / kStrip); }
  static std::size_t stripOf(int pixel) { return static_cast<std::size_t>(pixel / kStrip); }

  /** \brief A pixel reaches half a pixel beyond its ray; a whole one leaves room for rounding and for how lenses stretch. */
  static void widen(std::vector<Interval>& strips, float pixel) {
    for (Interval& strip : strips) {
      strip.low -= pixel;
      strip.high += pixel;
    }
  }

  static void reach(const std::vector<Interval>& strips, const Interval& box, int pixels, int margin,
                    std::int32_t& begin, std::int32_t& end) {
    begin = pixels;
    end = 0;
    for (std::size_t s = 0; s < strips.size(); ++s) {
      if (strips[s].high < box.low || strips[s].low > box.high) continue;
      const int first = static_cast<int>(s) * kStrip;
      begin = std::min(begin, std::max(0, first - margin));
      end = std::max(end, std::min(pixels, first + kStrip + margin));
    }
  }

  RigidTransform T_camera_world_;
  int width_, height_;
  std::vector<Interval> columns_, rows_;
};

}  // namespace distributed
}  // namespace fuse_flow
