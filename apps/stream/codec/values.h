#pragma once

#include "stream/codec/morton.h"

#include <cmath>
#include <cstdint>

namespace fuse_flow::stream {

using Triple = Few<std::uint8_t, 3>;
using Octahedral = Few<std::uint8_t, 2>;

FUSE_FLOW_HD std::uint8_t limited(int value) {
  return static_cast<std::uint8_t>(value < 0 ? 0 : value > 255 ? 255 : value);
}

/** \brief y, u, v of r, g, b, in steps of chroma. */
FUSE_FLOW_HD Triple toChroma(const Triple& rgb, int step) {
  const int r = rgb[0], g = rgb[1], b = rgb[2];
  const int y = (r + 2 * g + b + 2) / 4;
  const auto steps = [step](int difference) {
    const int magnitude = (2 * (difference < 0 ? -difference : difference) + step) / (2 * step);
    return limited(128 + (difference < 0 ? -magnitude : magnitude));
  };
  return {{static_cast<std::uint8_t>(y), steps(b - y), steps(r - y)}};
}

inline Triple fromChroma(const Triple& yuv, int step) {
  const int y = yuv[0];
  const std::uint8_t b = limited(y + step * (yuv[1] - 128)), r = limited(y + step * (yuv[2] - 128));
  const int twice = 4 * y - r - b;
  return {{r, limited(twice < 0 ? 0 : twice / 2), b}};
}

FUSE_FLOW_HD std::uint8_t confidenceByte(float confidence) {
  if (!(confidence > 0)) return 0;
  return static_cast<std::uint8_t>((confidence < 1.0f ? confidence : 1.0f) * 255.0f + 0.5f);
}

FUSE_FLOW_HD std::uint8_t viewCountByte(std::uint32_t views) {
  return static_cast<std::uint8_t>(views < 255u ? views : 255u);
}

/** \brief Octahedral: two bytes; 0, 0 for what is no direction. */
FUSE_FLOW_HD Octahedral toOctahedral(const float* normal) {
  const float x = normal[0], y = normal[1], z = normal[2];
  const float sum = std::abs(x) + std::abs(y) + std::abs(z);
  if (!(sum > 0) || !std::isfinite(sum)) return {{0, 0}};
  float p = x / sum, q = y / sum;
  if (z < 0) {
    const float folded = (1 - std::abs(q)) * (p < 0 ? -1.0f : 1.0f);
    q = (1 - std::abs(p)) * (q < 0 ? -1.0f : 1.0f);
    p = folded;
  }
  return {{static_cast<std::uint8_t>(128 + lroundf(127 * p)), static_cast<std::uint8_t>(128 + lroundf(127 * q))}};
}

inline void fromOctahedral(std::uint8_t p_byte, std::uint8_t q_byte, float* normal) {
  normal[0] = normal[1] = normal[2] = 0;
  if (p_byte == 0 && q_byte == 0) return;
  float p = static_cast<float>(p_byte - 128) / 127.0f, q = static_cast<float>(q_byte - 128) / 127.0f;
  const float z = 1 - std::abs(p) - std::abs(q);
  if (z < 0) {
    const float unfolded = (1 - std::abs(q)) * (p < 0 ? -1.0f : 1.0f);
    q = (1 - std::abs(p)) * (q < 0 ? -1.0f : 1.0f);
    p = unfolded;
  }
  const float length = std::sqrt(p * p + q * q + z * z);
  normal[0] = p / length;
  normal[1] = q / length;
  normal[2] = z / length;
}

/** \brief How the two neighbours of a point predict what it has. */
struct Prediction {
  std::uint32_t left{16};  ///< weight of the left one, of 16
  bool left_is_nearer{true};

  FUSE_FLOW_HD Prediction(const Lattice& left_point, const Lattice& point, const Lattice& right_point) {
    const std::uint32_t to_left = distance(point, left_point), to_right = distance(point, right_point);
    const std::uint32_t sum = to_left + to_right;
    left = sum == 0 ? 8 : 16 * to_right / sum;
    left_is_nearer = to_left <= to_right;
  }

 private:
  FUSE_FLOW_HD static std::uint32_t distance(const Lattice& a, const Lattice& b) {
    std::uint32_t sum = 0;
    for (std::size_t k = 0; k < 3; ++k) sum += a[k] > b[k] ? a[k] - b[k] : b[k] - a[k];
    return sum;  // below 3 · 2²¹, and 16 times that below 2³²
  }
};

}  // namespace fuse_flow::stream
