#pragma once

#include <fuse_flow/math/vec3.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief Chooses among points so that the directions of their normals come up as evenly as the points allow (Rusinkiewicz and
 *  Levoy 2001): a wall is many points, but tells of one direction only. */
class NormalSpaceSampling {
 public:
  void clear() {
    for (std::vector<std::uint32_t>& bin : bins_) bin.clear();
  }
  /** \brief \param n unit normal in a frame that all views share  \param point any number */
  void add(const Vec3& n, std::uint32_t point) { bins_[binOf(n)].push_back(point); }

  /** \brief At most count points: every bin gives as many, or all it has, evenly spaced in the order of add(). */
  void choose(std::size_t count, std::vector<std::uint32_t>& chosen) const {
    std::array<std::size_t, kBins> order;
    for (std::size_t b = 0; b < kBins; ++b) order[b] = b;
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return bins_[a].size() != bins_[b].size() ? bins_[a].size() < bins_[b].size() : a < b;
    });
    chosen.clear();
    for (std::size_t k = 0; k < kBins; ++k) {  // the smallest first: what they lack goes to the others
      const std::vector<std::uint32_t>& bin = bins_[order[k]];
      const std::size_t share = (count - chosen.size()) / (kBins - k);
      const std::size_t n = std::min(share, bin.size());
      for (std::size_t i = 0; i < n; ++i) chosen.push_back(bin[i * bin.size() / n]);
    }
  }

 private:
  /** \brief 3×3 bins on each face of a cube around the sphere of directions. */
  static constexpr std::size_t kBins = 6 * 9;

  static std::size_t binOf(const Vec3& n) {
    const float a[3] = {n.x, n.y, n.z};
    int face = 0;
    for (int k = 1; k < 3; ++k)
      if (std::fabs(a[k]) > std::fabs(a[face])) face = k;
    const float scale = 1.0f / std::fabs(a[face]);
    const auto third = [](float x) { return std::min(2, static_cast<int>(1.5f * (x + 1.0f))); };
    const int s = third(a[(face + 1) % 3] * scale), t = third(a[(face + 2) % 3] * scale);
    return static_cast<std::size_t>((2 * face + (a[face] > 0 ? 1 : 0)) * 9 + 3 * s + t);
  }

  std::array<std::vector<std::uint32_t>, kBins> bins_;
};

}  // namespace host
}  // namespace fuse_flow
