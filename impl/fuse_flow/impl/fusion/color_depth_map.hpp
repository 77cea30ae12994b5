#pragma once

#include <fuse_flow/math/view.h>

#include <algorithm>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief The memory of a ColorDepth, and how it is filled: see there. */
class ColorDepthMap {
 public:
  /** \brief Of what one view measured. \param surface has depth(u, v), metres, 0 where there is no measurement, and ray(u, v) */
  template <typename Surface>
  void assign(const ViewModel& view, const Surface& surface) {
    cells_ = ColorDepth::of(view.color_intrinsics, view.intrinsics);
    nearest_.assign(cells_.size(), ColorDepth::kNothing);
    for (int v = 0; v < view.intrinsics.height; ++v)
      for (int u = 0; u < view.intrinsics.width; ++u) {
        const float z = surface.depth(u, v);
        if (!(z > 0)) continue;
        const ColorPixel at = colorPixel(view, surface.ray(u, v), z);
        if (!at.known) continue;
        cells_.add(at.pixel, at.z,
                   [&](std::size_t cell, std::uint32_t bits) { nearest_[cell] = std::min(nearest_[cell], bits); });
      }
    cells_.nearest = nearest_.data();
  }

  /** \brief Nothing is hidden. */
  void clear() { cells_ = {}; }

  const ColorDepth& cells() const { return cells_; }

 private:
  ColorDepth cells_;
  std::vector<std::uint32_t> nearest_;
};

}  // namespace host
}  // namespace fuse_flow
