#pragma once

#include "stream/gpu/huffman_code.h"

#include <cstdint>

namespace fuse_flow::stream {

constexpr std::uint32_t kMostTreeBytes = 128;

/** \brief Finite state entropy coding of the weights in a tree's description: RFC 8878, 4.1 and 4.2.1.2. */
struct WeightCoder {
  static constexpr std::uint32_t kLog = 6, kStates = 1u << kLog;  ///< as many as Zstandard allows there
  static constexpr std::uint32_t kWeights = kMostCodeBits + 1;    ///< 0 … 11

  std::uint32_t shares[kWeights];  ///< states that a weight has; their sum is kStates
  std::uint32_t delta_bits[kWeights];
  std::int32_t delta_state[kWeights];
  std::uint8_t states[kStates];  ///< by weight, and then in their order
  std::uint8_t weight_of[kStates];
};

namespace detail {

/** \brief Bits into bytes, the lowest first; at most so many. */
struct TreeBits {
  std::uint8_t* to;
  std::uint32_t most, size{0}, count{0};
  std::uint64_t held{0};

  FUSE_FLOW_HD TreeBits(std::uint8_t* bytes, std::uint32_t most_bytes) : to(bytes), most(most_bytes) {}
  FUSE_FLOW_HD void put(std::uint32_t value, std::uint32_t bits) {
    held |= static_cast<std::uint64_t>(value) << count;
    count += bits;
    for (; count >= 8; count -= 8, held >>= 8) byte();
  }
  /** \brief The next byte begins. */
  FUSE_FLOW_HD void align() {
    if (count > 0) byte();
    count = 0;
    held = 0;
  }
  FUSE_FLOW_HD bool overflown() const { return size > most; }

 private:
  FUSE_FLOW_HD void byte() {
    if (size < most) to[size] = static_cast<std::uint8_t>(held);
    ++size;
  }
};

/** \brief Shares of the states in proportion to the counts, one at least. The most frequent weight gets what rounding leaves. */
FUSE_FLOW_HD void shareStates(const std::uint32_t* counts, std::uint32_t all, WeightCoder& coder) {
  std::uint32_t sum = 0, most = 0;
  for (std::uint32_t w = 0; w < WeightCoder::kWeights; ++w) {
    std::uint32_t share = (counts[w] * WeightCoder::kStates + all / 2) / all;
    if (counts[w] > 0 && share == 0) share = 1;
    coder.shares[w] = share;
    sum += share;
    if (counts[w] > counts[most]) most = w;
  }
  // 12 weights: rounding up costs at most 11, and the most frequent one has more.
  coder.shares[most] += WeightCoder::kStates - sum;
}

/** \brief The table that tells a decoder the shares. */
FUSE_FLOW_HD void putShares(const WeightCoder& coder, TreeBits& bits) {
  bits.put(WeightCoder::kLog - 5, 4);
  std::uint32_t remaining = WeightCoder::kStates + 1, threshold = WeightCoder::kStates, width = WeightCoder::kLog + 1;
  bool after_none = false;
  for (std::uint32_t w = 0; remaining > 1;) {
    if (after_none) {  // how many weights more have no share, by threes
      std::uint32_t none = 0;
      while (coder.shares[w + none] == 0) ++none;
      w += none;
      for (; none >= 3; none -= 3) bits.put(3, 2);
      bits.put(none, 2);
    }
    const std::uint32_t share = coder.shares[w++], most = 2 * threshold - 1 - remaining;
    remaining -= share;
    std::uint32_t value = share + 1;
    if (value >= threshold) value += most;
    bits.put(value, width - (value < most ? 1 : 0));
    after_none = share == 0;
    while (remaining < threshold) {
      --width;
      threshold >>= 1;
    }
  }
  bits.align();
}

/** \brief Which states a weight has, and how to get from one to the next. */
FUSE_FLOW_HD void makeStates(WeightCoder& coder) {
  constexpr std::uint32_t states = WeightCoder::kStates, step = (states >> 1) + (states >> 3) + 3;
  std::uint32_t position = 0, begin[WeightCoder::kWeights], sum = 0;
  for (std::uint32_t w = 0; w < WeightCoder::kWeights; ++w) {
    const std::uint32_t share = coder.shares[w];
    begin[w] = sum;
    for (std::uint32_t k = 0; k < share; ++k) {
      coder.weight_of[position] = static_cast<std::uint8_t>(w);
      position = (position + step) % states;
    }
    if (share == 1) {
      coder.delta_bits[w] = (WeightCoder::kLog << 16) - states;
      coder.delta_state[w] = static_cast<std::int32_t>(sum) - 1;
    } else if (share > 1) {
      const std::uint32_t most_bits = WeightCoder::kLog - static_cast<std::uint32_t>(bitLength(share - 1) - 1);
      coder.delta_bits[w] = (most_bits << 16) - (share << most_bits);
      coder.delta_state[w] = static_cast<std::int32_t>(sum) - static_cast<std::int32_t>(share);
    }
    sum += share;
  }
  for (std::uint32_t k = 0; k < states; ++k)
    coder.states[begin[coder.weight_of[k]]++] = static_cast<std::uint8_t>(states + k);
}

/** \brief One of the two states that take turns. */
struct WeightState {
  const WeightCoder* coder;
  std::uint32_t state;

  FUSE_FLOW_HD WeightState(const WeightCoder& of, std::uint32_t weight) : coder(&of) {
    const std::uint32_t bits = (of.delta_bits[weight] + (1u << 15)) >> 16;
    state = next(((bits << 16) - of.delta_bits[weight]) >> bits, weight);
  }
  FUSE_FLOW_HD void put(std::uint32_t weight, TreeBits& to) {
    const std::uint32_t bits = (state + coder->delta_bits[weight]) >> 16;
    to.put(state & ((1u << bits) - 1), bits);
    state = next(state >> bits, weight);
  }
  FUSE_FLOW_HD void end(TreeBits& to) const { to.put(state & (WeightCoder::kStates - 1), WeightCoder::kLog); }

 private:
  FUSE_FLOW_HD std::uint32_t next(std::uint32_t high, std::uint32_t weight) const {
    return coder->states[static_cast<std::int32_t>(high) + coder->delta_state[weight]];
  }
};

FUSE_FLOW_HD std::uint32_t weightOf(const HuffmanCode& code, std::uint32_t byte) {
  const std::uint32_t l = HuffmanCode::lengthOf(code.codes[byte]);
  return l == 0 ? 0 : code.longest + 1 - l;
}

/** \returns how many bytes it takes; 0: more than it may */
FUSE_FLOW_HD std::uint32_t writeCodedWeights(const HuffmanCode& code, WeightCoder& coder, std::uint8_t* to,
                                             std::uint32_t most) {
  // The weights of the bytes before the last one, whose weight a decoder finds out.
  std::uint32_t counts[WeightCoder::kWeights] = {}, kinds = 0;
  for (std::uint32_t w = 1; w <= code.longest; ++w) counts[w] = code.of_length[code.longest + 1 - w];
  --counts[weightOf(code, code.last)];
  counts[0] = code.last + 1 - code.bytes;
  for (const std::uint32_t count : counts) kinds += count > 0;
  if (code.last < 3 || kinds < 2) return 0;
  shareStates(counts, code.last, coder);
  TreeBits bits(to, most);
  putShares(coder, bits);
  makeStates(coder);
  // Backwards: a decoder reads from the end. Those at even places are one state's.
  std::uint32_t at = code.last;
  const bool odd = at % 2 == 1;
  const std::uint32_t a = weightOf(code, at - 1), b = weightOf(code, at - 2);
  WeightState even_state(coder, odd ? a : b), odd_state(coder, odd ? b : a);
  for (at -= 2; at > 0; --at) {
    const std::uint32_t weight = weightOf(code, at - 1);
    if ((at - 1) % 2 == 0) {
      even_state.put(weight, bits);
    } else {
      odd_state.put(weight, bits);
    }
  }
  odd_state.end(bits);
  even_state.end(bits);
  bits.put(1, 1);
  bits.align();
  return bits.overflown() ? 0 : bits.size;
}

}  // namespace detail

/** \brief The description of a code's tree. \param to kMostTreeBytes \returns how many; 0: it cannot be described */
FUSE_FLOW_HD std::uint32_t writeHuffmanTree(const HuffmanCode& code, WeightCoder& coder, std::uint8_t* to) {
  const std::uint32_t coded = detail::writeCodedWeights(code, coder, to + 1, kMostTreeBytes - 1);
  const std::uint32_t plain = code.last <= 128 ? (code.last + 1) / 2 : 0;  // a byte for two weights
  if (coded > 0 && (plain == 0 || coded < plain)) {
    to[0] = static_cast<std::uint8_t>(coded);
    return 1 + coded;
  }
  if (plain == 0) return 0;
  to[0] = static_cast<std::uint8_t>(127 + code.last);
  for (std::uint32_t k = 0; k < plain; ++k) {
    const std::uint32_t high = detail::weightOf(code, 2 * k);
    const std::uint32_t low = 2 * k + 1 < code.last ? detail::weightOf(code, 2 * k + 1) : 0;
    to[1 + k] = static_cast<std::uint8_t>(high << 4 | low);
  }
  return 1 + plain;
}

}  // namespace fuse_flow::stream
