#pragma once

#include "stream/codec/morton.h"

#include <cstdint>

namespace fuse_flow::stream {

constexpr std::uint64_t kParts = 16;  ///< of the interval between two neighbours, each a token

/** \brief A position as it is written: a token, and bits that follow among the raw ones. */
struct Token {
  std::uint64_t token;
  std::uint64_t bits;  ///< the lowest first
  int count;           ///< of bits
};

/** \brief A part of the interval, and a number 0 … w − 1 in as few whole bits as that allows. */
FUSE_FLOW_HD Token tokenAndRest(std::uint64_t token, std::uint64_t rest, std::uint64_t w) {
  const int k = bitLength(w - 1);
  if (k == 0) return {token, 0, 0};
  const std::uint64_t u = (std::uint64_t{1} << k) - w;
  if (rest < u) return {token, rest, k - 1};
  return {token, (rest + u) >> 1 | ((rest + u) & 1) << (k - 1), k};
}

/** \brief Of a point between two neighbours. \param d from the left one, of codes  \param interval from the left to the right one */
FUSE_FLOW_HD Token tokenBetween(std::uint64_t d, std::uint64_t interval) {
  if (interval >> 32 == 0) {  // as good as always; divided faster
    const auto w = static_cast<std::uint32_t>(interval / kParts + 1);
    const std::uint32_t token = static_cast<std::uint32_t>(d) / w;
    return tokenAndRest(token, static_cast<std::uint32_t>(d) - token * w, w);
  }
  const std::uint64_t w = interval / kParts + 1, token = d / w;
  return tokenAndRest(token, d - token * w, w);
}

/** \brief Of a point that has a left neighbour alone. */
FUSE_FLOW_HD Token tokenAfter(std::uint64_t d) {
  const int n = bitLength(d);
  const std::uint64_t token = kParts + 2 * static_cast<unsigned>(n);
  if (n < 2) return {token, 0, 0};
  return {token + (d >> (n - 2) & 1), d & ((std::uint64_t{1} << (n - 2)) - 1), n - 2};
}

}  // namespace fuse_flow::stream
