#pragma once

#include "stream/codec/morton.h"
#include "stream/gpu/team.h"

#include <cstdint>

namespace fuse_flow::stream {

constexpr std::uint32_t kMostCodeBits = 11;  ///< that Zstandard allows

/** \brief Codes of bytes, as Zstandard derives them from their lengths (RFC 8878, 4.2.1.3), and what it takes to find them. */
struct HuffmanCode {
  std::uint32_t counts[256];  ///< how often each byte occurs: what it is made for
  std::uint32_t codes[256];   ///< the code of a byte, and its length above bit 16; 0: it does not occur
  std::uint32_t of_length[kMostCodeBits + 2];   ///< how many codes have a length
  std::uint32_t first_code[kMostCodeBits + 2];  ///< of those with a length
  std::uint32_t bytes;                          ///< that occur
  std::uint32_t last;                           ///< the greatest that does
  std::uint32_t longest;                        ///< length of a code

  // The tree: the bytes in the order of their counts, and then the nodes above them.
  std::uint8_t sorted[256];
  std::uint32_t weights[511];
  std::uint16_t parents[511];

  FUSE_FLOW_HD static std::uint32_t lengthOf(std::uint32_t code) { return code >> 16; }
};

namespace detail {

/** \brief Puts nodes above the lightest ones until there is a single one. The new ones come out in the order of their weights, so that the
 *  lightest is always the first of two rows. */
FUSE_FLOW_HD void joinNodes(HuffmanCode& code) {
  const std::uint32_t leaves = code.bytes;
  std::uint32_t leaf = 0, node = leaves;
  std::uint32_t lightest_leaf = code.weights[0], lightest_node = 0;
  for (std::uint32_t next = leaves; next < 2 * leaves - 1; ++next) {
    std::uint32_t sum = 0;
    for (int child = 0; child < 2; ++child) {
      if (leaf < leaves && (node >= next || lightest_leaf <= lightest_node)) {
        sum += lightest_leaf;
        code.parents[leaf++] = static_cast<std::uint16_t>(next);
        if (leaf < leaves) lightest_leaf = code.weights[leaf];
      } else {
        sum += lightest_node;
        code.parents[node++] = static_cast<std::uint16_t>(next);
        if (node < next) lightest_node = code.weights[node];
      }
    }
    code.weights[next] = sum;
    if (node == next) lightest_node = sum;
  }
}

/** \brief Codes were cut to the greatest length, and now there are too many. Until they fit, that byte's code becomes longer by one which
 *  costs least for what it sets free; what is then free makes codes shorter again. */
FUSE_FLOW_HD void limitLengths(HuffmanCode& code) {
  constexpr std::uint32_t all = 1u << kMostCodeBits;  // a code of length l uses 2^(kMostCodeBits − l) of them
  const auto freed = [](std::uint32_t l) { return 1u << (kMostCodeBits - 1 - l); };  // by one more bit
  std::uint32_t* const rarest = code.first_code;  // of a length, in the order of the counts: the longest come first
  std::uint32_t used = 0, place = 0;
  for (std::uint32_t l = kMostCodeBits; l > 0; --l) {
    used += code.of_length[l] << (kMostCodeBits - l);
    rarest[l] = place;
    place += code.of_length[l];
  }
  while (used > all) {
    const std::uint32_t excess = used - all;
    std::uint32_t best = 0, best_cost = 0, best_gain = 0;
    for (std::uint32_t l = 1; l < kMostCodeBits; ++l) {
      if (code.of_length[l] == 0) continue;
      const std::uint32_t cost = code.weights[rarest[l]], gain = freed(l) < excess ? freed(l) : excess;
      if (best > 0 && cost * best_gain >= best_cost * gain) continue;
      best = l;
      best_cost = cost;
      best_gain = gain;
    }
    --code.of_length[best];
    ++code.of_length[best + 1];
    ++rarest[best];
    used -= freed(best);
  }
  while (used < all) {
    // What is free is a multiple of what the longest codes use.
    std::uint32_t l = 1;
    while (freed(l) > all - used || code.of_length[l + 1] == 0) ++l;
    ++code.of_length[l];
    --code.of_length[l + 1];
    used += freed(l);
  }
  code.longest = kMostCodeBits;
  while (code.of_length[code.longest] == 0) --code.longest;
  std::uint32_t first = 0;
  for (std::uint32_t l = code.longest; l > 0; --l) {
    code.first_code[l] = first;
    first = (first + code.of_length[l]) >> 1;
  }
}

}  // namespace detail

/** \brief Of the counts, of which two at least are not 0. The same counts give the same codes, whatever the team. */
FUSE_FLOW_CALLS_ANY
template <typename Team>
FUSE_FLOW_HD void makeHuffmanCode(const Team& team, HuffmanCode& code) {
  team.once([&] { code.bytes = code.last = 0; });
  team.forEach(kMostCodeBits + 2, [&](std::uint32_t l) { code.of_length[l] = 0; });
  team.forEach(256, [&](std::uint32_t byte) {
    code.codes[byte] = 0;
    const std::uint32_t count = code.counts[byte];
    if (count == 0) return;
    std::uint32_t before = 0;
    for (std::uint32_t other = 0; other < 256; ++other) {
      const std::uint32_t of_other = code.counts[other];
      if (of_other > 0 && (of_other < count || (of_other == count && other < byte))) ++before;
    }
    code.sorted[before] = static_cast<std::uint8_t>(byte);
    code.weights[before] = count;
    team.add(&code.bytes, 1);
    team.raise(&code.last, byte);
  });
  team.once([&] { detail::joinNodes(code); });
  team.forEach(code.bytes, [&](std::uint32_t leaf) {
    std::uint32_t depth = 0;
    for (std::uint32_t node = leaf; node != 2 * code.bytes - 2; node = code.parents[node]) ++depth;
    team.add(&code.of_length[depth < kMostCodeBits ? depth : kMostCodeBits], 1);
  });
  team.once([&] { detail::limitLengths(code); });
  // The rarest bytes have the longest codes.
  team.forEach(code.bytes, [&](std::uint32_t place) {
    std::uint32_t l = code.longest, upto = code.of_length[l];
    while (place >= upto) upto += code.of_length[--l];
    code.codes[code.sorted[place]] = l << 16;
  });
  team.forEach(256, [&](std::uint32_t byte) {
    const std::uint32_t l = HuffmanCode::lengthOf(code.codes[byte]);
    std::uint32_t number = code.first_code[l];
    for (std::uint32_t other = 0; other < byte; ++other) number += HuffmanCode::lengthOf(code.codes[other]) == l;
    code.weights[byte] = l == 0 ? 0 : l << 16 | number;  // the lengths are still being read
  });
  team.forEach(256, [&](std::uint32_t byte) { code.codes[byte] = code.weights[byte]; });
}

}  // namespace fuse_flow::stream
