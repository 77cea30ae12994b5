#pragma once

#include <fuse_flow/gpu/sensors/device_view.h>
#include <fuse_flow/math/calibration/block_average.h>

#include <cstring>

namespace fuse_flow {
namespace gpu {

/** \brief Of how many values, and which is their median, the upper one of two. */
struct Median {
  std::uint32_t count;
  float value;
};

/** \brief The squared sines between normals of one view, and their median: found bit by bit, by counting how many begin with the
 *  bits that are known, so that it is the one that sorting would find. No sine is negative: their bits are in their order. As a step
 *  of forEach() it works on one view; the CUDA kernel gives each a block. */
struct MeasureNormalNoise {
  PixelGrid grid;
  const Vec3* normals;
  Median* medians;

  static constexpr std::uint32_t kBins = 256;  ///< of the eight bits that come next
  static constexpr int kRounds = 4;

  /** \brief Pairs of one view that may have a sine. */
  FUSE_FLOW_HD std::uint32_t pairs(const DeviceView& view) const {
    return view.present ? columns(view) * ((static_cast<std::uint32_t>(view.model.intrinsics.height) + 1) / 2) : 0;
  }
  /** \brief The bits of the sine of a pair; false if it has none. */
  FUSE_FLOW_HD bool sine(const DeviceView& view, std::uint32_t pair, std::uint32_t& bits) const {
    const std::uint32_t row = pair / columns(view);
    const int u = static_cast<int>(pair - row * columns(view)) * kNormalStride,
              v = static_cast<int>(row) * kNormalStride;
    const float sine = squaredSine(normals[view.indexOf(u, v)], normals[view.indexOf(u + kNormalsApart, v)]);
    std::memcpy(&bits, &sine, sizeof bits);
    return sine >= 0;
  }
  /** \brief Whether the bits that are known before a round are the first of a value's. */
  FUSE_FLOW_HD static bool begins(std::uint32_t bits, std::uint32_t known, int round) {
    return round == 0 || bits >> (32 - 8 * round) == known;
  }
  FUSE_FLOW_HD static std::uint32_t binOf(std::uint32_t bits, int round) { return bits >> (24 - 8 * round) & 255u; }

  FUSE_FLOW_HD void set(std::uint32_t view, std::uint32_t count, std::uint32_t bits) const {
    medians[view].count = count;
    std::memcpy(&medians[view].value, &bits, sizeof bits);
  }

  FUSE_FLOW_HD void operator()(std::uint32_t i) const {
    const DeviceView& view = grid.views[i];
    std::uint32_t known = 0, rank = 0, count = 0;
    for (int round = 0; round < kRounds; ++round) {
      std::uint32_t counts[kBins] = {};
      for (std::uint32_t pair = 0; pair < pairs(view); ++pair) {
        std::uint32_t bits = 0;
        if (!sine(view, pair, bits)) continue;
        if (round == 0) ++count;
        if (begins(bits, known, round)) ++counts[binOf(bits, round)];
      }
      if (count == 0) break;
      if (round == 0) rank = count / 2;
      std::uint32_t bin = 0;
      for (; rank >= counts[bin]; ++bin) rank -= counts[bin];
      known = known << 8 | bin;
    }
    set(i, count, known);
  }

 private:
  FUSE_FLOW_HD static std::uint32_t columns(const DeviceView& view) {
    const int width = view.model.intrinsics.width - kNormalsApart;
    return width > 0 ? static_cast<std::uint32_t>((width + kNormalStride - 1) / kNormalStride) : 0u;
  }
};

}  // namespace gpu
}  // namespace fuse_flow
