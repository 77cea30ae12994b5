#pragma once

#include <fuse_flow/math/host_device.h>

#include <cstdint>

namespace fuse_flow {

/** \brief Candidates of one pixel, see candidateOffset(): four areas near and four far. */
constexpr int kPropagationAreas = 8;
/** \brief Of them near: enough for an image whose half was done before. */
constexpr int kNearAreas = 4;
/** \brief Pixels of an area near the pixel. */
constexpr int kNearOffsets = 7;
/** \brief Pixels of an area far from the pixel. */
constexpr int kFarOffsets = 11;

/** \brief Pixels beside a pixel, in pixels. */
struct PixelOffset {
  int u;  ///< to the right
  int v;  ///< down
};

/** \brief Pixel k of an area from which a pixel takes over planes: four V-shaped areas near it, up, down, left and right, then four strips
 *  that reach 23 pixels far (Xu and Tao, Multi-Scale Geometric Consistency Guided Multi-View Stereo, CVPR 2019). u + v is odd for all of
 *  them: on a checkerboard they have the other colour. */
FUSE_FLOW_HD PixelOffset candidateOffset(int area, int k) {
  const int direction = area & 3;
  int away, aside;
  if (area < kNearAreas) {
    const int step = (k + 1) / 2;  // 0, 1, 1, 2, 2, 3, 3
    away = 1 + step;
    aside = (k & 1) != 0 ? -step : step;
  } else {
    away = 3 + 2 * k;
    aside = 0;
  }
  switch (direction) {
    case 0:
      return {aside, -away};
    case 1:
      return {aside, away};
    case 2:
      return {-away, aside};
    default:
      return {away, aside};
  }
}

/** \brief Random numbers that depend on a seed alone, the same on every device. */
class PixelRandom {
 public:
  /** \brief One sequence for each pixel of each view in each pass. */
  FUSE_FLOW_HD PixelRandom(std::uint32_t seed, std::uint32_t view, std::uint32_t pixel, std::uint32_t pass)
      : state_(mixed(mixed(mixed(seed * 0x9e3779b9u + pass) + view * 0x85ebca6bu) + pixel)) {}

  /** \brief The next one, uniform in [−1, 1). */
  FUSE_FLOW_HD float next() {
    state_ += 0x9e3779b9u;
    return static_cast<float>(static_cast<int>(mixed(state_) >> 8)) * (1.0f / 8388608.0f) - 1.0f;
  }

 private:
  /** \brief A hash of 32 bits in which every bit of the input matters to every bit of the output (C. Wellons' lowbias32). */
  FUSE_FLOW_HD static std::uint32_t mixed(std::uint32_t x) {
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    x ^= x >> 16;
    return x;
  }

  std::uint32_t state_;
};

}  // namespace fuse_flow
