#pragma once

#include <fuse_flow/math/pinhole.h>

#include <algorithm>
#include <cmath>

namespace fuse_flow {
namespace detail {

/** \brief The image without distortion that shows what an image shows: the same focal lengths, as large as the rays of its border need, up to
 *  twice the width and height. */
inline Intrinsics idealIntrinsics(const Intrinsics& K) {
  if (isIdeal(K.distortion)) return K;
  float left = 0, right = 0, up = 0, down = 0;  // rays
  const auto include = [&](int u, int v) {
    const Ray ray = unproject(K, {static_cast<float>(u), static_cast<float>(v)});
    if (!std::isfinite(ray.x) || !std::isfinite(ray.y)) return;
    left = std::min(left, ray.x), right = std::max(right, ray.x);
    up = std::min(up, ray.y), down = std::max(down, ray.y);
  };
  for (int u = 0; u < K.width; ++u) include(u, 0), include(u, K.height - 1);
  for (int v = 0; v < K.height; ++v) include(0, v), include(K.width - 1, v);
  const float most_x = static_cast<float>(K.width) / K.fx, most_y = static_cast<float>(K.height) / K.fy;
  left = std::max(left, -most_x), right = std::min(right, most_x);
  up = std::max(up, -most_y), down = std::min(down, most_y);
  Intrinsics ideal;
  ideal.fx = K.fx;
  ideal.fy = K.fy;
  ideal.cx = std::ceil(-left * K.fx);
  ideal.cy = std::ceil(-up * K.fy);
  ideal.width = static_cast<int>(ideal.cx + std::ceil(right * K.fx)) + 1;
  ideal.height = static_cast<int>(ideal.cy + std::ceil(down * K.fy)) + 1;
  return ideal;
}

/** \brief Of an image of which each 2 × 2 pixels have become one. */
inline Intrinsics halved(const Intrinsics& K) {
  Intrinsics half;
  half.width = K.width / 2;
  half.height = K.height / 2;
  half.fx = 0.5f * K.fx;
  half.fy = 0.5f * K.fy;
  half.cx = 0.5f * (K.cx + 0.5f) - 0.5f;
  half.cy = 0.5f * (K.cy + 0.5f) - 0.5f;
  return half;
}

}  // namespace detail
}  // namespace fuse_flow
