#pragma once

#include <fuse_flow/math/vec3.h>

#include <cstddef>
#include <cstdint>

namespace fuse_flow {

/** \brief Bins of directions: 3×3 on each face of a cube around their sphere. */
constexpr std::size_t kNormalBins = 6 * 9;

/** \brief The bin of a unit vector. */
FUSE_FLOW_HD std::size_t normalBin(const Vec3& n) {
  const float a[3] = {n.x, n.y, n.z};
  int face = 0;
  for (int k = 1; k < 3; ++k)
    if (std::fabs(a[k]) > std::fabs(a[face])) face = k;
  const float scale = 1.0f / std::fabs(a[face]);
  const auto third = [](float x) {
    const int t = static_cast<int>(1.5f * (x + 1.0f));
    return t < 2 ? t : 2;
  };
  const int s = third(a[(face + 1) % 3] * scale), t = third(a[(face + 2) % 3] * scale);
  return static_cast<std::size_t>((2 * face + (a[face] > 0 ? 1 : 0)) * 9 + 3 * s + t);
}

/** \brief Of the members of a bin, in their order, the i-th that is chosen if n of them are, evenly spaced. */
FUSE_FLOW_HD std::size_t evenlySpaced(std::size_t i, std::size_t size, std::size_t n) { return i * size / n; }

/** \brief Place of a pixel along a curve through all squares, within them through all of their quarters, and so on: neighbours in
 *  the image become neighbours on it. \param u, v under 65536 */
FUSE_FLOW_HD std::uint32_t mortonCode(std::uint32_t u, std::uint32_t v) {
  const auto spread = [](std::uint32_t x) {
    x = (x | x << 8) & 0x00ff00ffu;
    x = (x | x << 4) & 0x0f0f0f0fu;
    x = (x | x << 2) & 0x33333333u;
    return (x | x << 1) & 0x55555555u;
  };
  return spread(u) | spread(v) << 1;
}

}  // namespace fuse_flow
