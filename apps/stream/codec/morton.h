#pragma once

#include <fuse_flow/math/host_device.h>

#include <cstddef>
#include <cstdint>

namespace fuse_flow::stream {

/** \brief Bits of a coordinate that a Morton code has. */
constexpr int kCoordinateBits = 21;

/** \brief Some numbers, as std::array, whose functions a GPU does not have. */
template <typename T, int kCount>
struct Few {
  T value[kCount];

  FUSE_FLOW_HD T& operator[](std::size_t k) { return value[k]; }
  FUSE_FLOW_HD const T& operator[](std::size_t k) const { return value[k]; }
};

using Lattice = Few<std::uint32_t, 3>;  ///< x, y, z in steps

namespace detail {

/** \brief Bit k goes to bit 3k. */
FUSE_FLOW_HD std::uint64_t spread(std::uint64_t v) {
  v = (v | v << 32) & 0x1f00000000ffffu;
  v = (v | v << 16) & 0x1f0000ff0000ffu;
  v = (v | v << 8) & 0x100f00f00f00f00fu;
  v = (v | v << 4) & 0x10c30c30c30c30c3u;
  return (v | v << 2) & 0x1249249249249249u;
}

/** \brief Back. */
FUSE_FLOW_HD std::uint32_t gather(std::uint64_t v) {
  v &= 0x1249249249249249u;
  v = (v ^ v >> 2) & 0x10c30c30c30c30c3u;
  v = (v ^ v >> 4) & 0x100f00f00f00f00fu;
  v = (v ^ v >> 8) & 0x1f0000ff0000ffu;
  v = (v ^ v >> 16) & 0x1f00000000ffffu;
  return static_cast<std::uint32_t>((v ^ v >> 32) & 0x1fffffu);
}

}  // namespace detail

/** \brief Points that follow one another in the order of this code are near one another. */
FUSE_FLOW_HD std::uint64_t mortonCode(const Lattice& p) {
  return detail::spread(p[0]) | detail::spread(p[1]) << 1 | detail::spread(p[2]) << 2;
}

FUSE_FLOW_HD Lattice fromMortonCode(std::uint64_t code) {
  return {{detail::gather(code), detail::gather(code >> 1), detail::gather(code >> 2)}};
}

/** \brief How many bits a number has; 0 has none. */
FUSE_FLOW_HD int bitLength(std::uint64_t v) {
#if defined(__CUDA_ARCH__)
  return 64 - __clzll(static_cast<long long>(v));
#else
  return v == 0 ? 0 : 64 - __builtin_clzll(v);
#endif
}

}  // namespace fuse_flow::stream
