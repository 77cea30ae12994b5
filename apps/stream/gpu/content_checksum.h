#pragma once

#include "stream/gpu/team.h"

#include <cstdint>
#include <cstring>

namespace fuse_flow::stream {

namespace detail {

/** \brief XXH64, the checksum of Zstandard's frames, without a seed. Its four lanes run side by side. */
struct ContentHash {
  static constexpr std::uint64_t kPrime1 = 0x9E3779B185EBCA87u, kPrime2 = 0xC2B2AE3D27D4EB4Fu,
                                 kPrime3 = 0x165667B19E3779F9u, kPrime4 = 0x85EBCA77C2B2AE63u,
                                 kPrime5 = 0x27D4EB2F165667C5u;

  FUSE_FLOW_HD static std::uint64_t turned(std::uint64_t v, int bits) { return v << bits | v >> (64 - bits); }
  FUSE_FLOW_HD static std::uint64_t round(std::uint64_t sum, std::uint64_t word) {
    return turned(sum + word * kPrime2, 31) * kPrime1;
  }
  /** \brief Eight bytes, aligned on a GPU. */
  FUSE_FLOW_HD static std::uint64_t word(const std::uint8_t* from) {
#if defined(__CUDA_ARCH__)
    return __ldg(reinterpret_cast<const unsigned long long*>(from));
#else
    std::uint64_t value;
    std::memcpy(&value, from, 8);
    return value;
#endif
  }

  /** \brief One lane over all stripes of 32 bytes. Some words at a time are on their way from memory. */
  FUSE_FLOW_HD static std::uint64_t lane(std::uint32_t number, const std::uint8_t* from, std::uint32_t stripes) {
    std::uint64_t sum = number == 0 ? kPrime1 + kPrime2 : number == 1 ? kPrime2 : number == 2 ? 0 : 0 - kPrime1;
    from += stripes > 0 ? 8 * number : 0;  // of no bytes there may be no address
    constexpr std::uint32_t some = 16;
    std::uint64_t next[some], now[some];
    std::uint32_t at = 0;
    if (stripes >= some) {
      for (std::uint32_t k = 0; k < some; ++k) next[k] = word(from + 32 * k);
      for (; at + some <= stripes; at += some) {
        for (std::uint32_t k = 0; k < some; ++k) now[k] = next[k];
        if (at + 2 * some <= stripes)
          for (std::uint32_t k = 0; k < some; ++k) next[k] = word(from + 32 * (at + some + k));
        for (std::uint32_t k = 0; k < some; ++k) sum = round(sum, now[k]);
      }
    }
    for (; at < stripes; ++at) sum = round(sum, word(from + 32 * at));
    return sum;
  }

  FUSE_FLOW_HD static std::uint64_t end(const std::uint64_t* lanes, const std::uint8_t* from, std::uint32_t size) {
    std::uint64_t hash = kPrime5;
    if (size >= 32) {
      hash = turned(lanes[0], 1) + turned(lanes[1], 7) + turned(lanes[2], 12) + turned(lanes[3], 18);
      for (int k = 0; k < 4; ++k) hash = (hash ^ round(0, lanes[k])) * kPrime1 + kPrime4;
    }
    hash += size;
    std::uint32_t at = size / 32 * 32;
    for (; at + 8 <= size; at += 8) hash = turned(hash ^ round(0, word(from + at)), 27) * kPrime1 + kPrime4;
    if (at + 4 <= size) {
      std::uint64_t value = 0;
      for (std::uint32_t k = 0; k < 4; ++k) value |= static_cast<std::uint64_t>(from[at + k]) << (8 * k);
      hash = turned(hash ^ value * kPrime1, 23) * kPrime2 + kPrime3;
      at += 4;
    }
    for (; at < size; ++at) hash = turned(hash ^ from[at] * kPrime5, 11) * kPrime1;
    hash = (hash ^ hash >> 33) * kPrime2;
    hash = (hash ^ hash >> 29) * kPrime3;
    return hash ^ hash >> 32;
  }
};

}  // namespace detail

/** \brief What ends a frame of Zstandard with this content. \param lanes four words that the team shares */
FUSE_FLOW_CALLS_ANY
template <typename Team>
FUSE_FLOW_HD void contentChecksum(const Team& team, std::uint64_t* lanes, const std::uint8_t* from, std::uint32_t size,
                                  std::uint32_t* checksum) {
  team.forEach(4, [&](std::uint32_t k) { lanes[k] = detail::ContentHash::lane(k, from, size / 32); });
  team.once([&] { *checksum = static_cast<std::uint32_t>(detail::ContentHash::end(lanes, from, size)); });
}

}  // namespace fuse_flow::stream
