#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace fuse_flow::stream {

/** \brief Bits of a coordinate that a Morton code has. */
constexpr int kCoordinateBits = 21;

using Lattice = std::array<std::uint32_t, 3>;  ///< x, y, z in steps

namespace detail {

/** \brief Bit k goes to bit 3k. */
inline std::uint64_t spread(std::uint64_t v) {
  v = (v | v << 32) & 0x1f00000000ffffu;
  v = (v | v << 16) & 0x1f0000ff0000ffu;
  v = (v | v << 8) & 0x100f00f00f00f00fu;
  v = (v | v << 4) & 0x10c30c30c30c30c3u;
  return (v | v << 2) & 0x1249249249249249u;
}

/** \brief Back. */
inline std::uint32_t gather(std::uint64_t v) {
  v &= 0x1249249249249249u;
  v = (v ^ v >> 2) & 0x10c30c30c30c30c3u;
  v = (v ^ v >> 4) & 0x100f00f00f00f00fu;
  v = (v ^ v >> 8) & 0x1f0000ff0000ffu;
  v = (v ^ v >> 16) & 0x1f00000000ffffu;
  return static_cast<std::uint32_t>((v ^ v >> 32) & 0x1fffffu);
}

}  // namespace detail

/** \brief Points that follow one another in the order of this code are near one another. */
inline std::uint64_t mortonCode(const Lattice& p) {
  return detail::spread(p[0]) | detail::spread(p[1]) << 1 | detail::spread(p[2]) << 2;
}

inline Lattice fromMortonCode(std::uint64_t code) {
  return {detail::gather(code), detail::gather(code >> 1), detail::gather(code >> 2)};
}

/** \brief How many bits a number has; 0 has none. */
inline int bitLength(std::uint64_t v) { return v == 0 ? 0 : 64 - __builtin_clzll(v); }

}  // namespace fuse_flow::stream
