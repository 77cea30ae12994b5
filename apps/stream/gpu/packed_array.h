#pragma once

#include "stream/gpu/huffman_tree_bytes.h"

#include <cstdint>
#include <cstring>

/** \file
 *  \brief Arrays as blocks of Zstandard (RFC 8878, 3.1.1.2) that have only literals: bytes, each by Huffman's code, as next to nothing in a
 *  layer repeats. */

namespace fuse_flow::stream {

constexpr std::uint32_t kMostBlockBytes = 1u << 17;  ///< of what a block unpacks to

/** \brief A block: some bytes here, and then those of its streams, or of the array as it is. */
struct PackedArray {
  enum Kind : std::uint32_t { kAbsent, kStored, kRepeated, kPacked };
  std::uint32_t kind;
  std::uint32_t head_bytes, body_bytes;
  std::uint8_t head[148];  ///< block header, header of the literals, tree, sizes of three streams
};

/** \brief What a team packs with. */
struct PackWorkspace {
  static constexpr std::uint32_t kParts = kTeamThreads;  ///< of the array, each packed by itself

  HuffmanCode code;
  WeightCoder coder;
  std::uint32_t most;          ///< how often the most frequent byte occurs
  std::uint32_t bits[kParts];  ///< before each part
  std::uint32_t streams, tree_bytes;
  std::uint32_t bits_of_stream[4], begin_of_stream[5];  ///< bits, bytes
  std::uint8_t tree[kMostTreeBytes];
};

namespace detail {

/** \brief A part of an array: bytes from first to end, which are packed backwards, as a decoder reads from the end. */
struct PackedPart {
  std::uint32_t stream, first, end;

  FUSE_FLOW_HD PackedPart(std::uint32_t part, std::uint32_t size, std::uint32_t streams) {
    const std::uint32_t of_stream = PackWorkspace::kParts / streams, segment = (size + streams - 1) / streams;
    stream = part / of_stream;
    const std::uint32_t begin = stream * segment, last = size < begin + segment ? size : begin + segment;
    const std::uint32_t bytes = (segment + of_stream - 1) / of_stream, behind = part % of_stream * bytes;
    end = last - begin > behind ? last - behind : begin;
    first = end - begin > bytes ? end - bytes : begin;
  }
};

/** \brief Calls visit(code) for the bytes of a part, from the last to the first. Some at a time are on their way from memory. */
FUSE_FLOW_CALLS_ANY
template <typename Visit>
FUSE_FLOW_HD void forEachCode(const std::uint8_t* from, const PackedPart& part, const std::uint32_t* codes,
                              const Visit& visit) {
  constexpr std::uint32_t some = 8;
  std::uint32_t at = part.end;
  for (; at >= part.first + some; at -= some) {
    std::uint32_t next[some];
    for (std::uint32_t k = 0; k < some; ++k) next[k] = from[at - 1 - k];
    for (std::uint32_t k = 0; k < some; ++k) next[k] = codes[next[k]];
    for (std::uint32_t k = 0; k < some; ++k) visit(next[k]);
  }
  for (; at > part.first; --at) visit(codes[from[at - 1]]);
}

FUSE_FLOW_CALLS_ANY
template <typename Team>
FUSE_FLOW_HD void countBytes(const Team& team, const std::uint8_t* from, std::uint32_t size, std::uint32_t* counts) {
  // Sixteen that lie together in memory at a time.
  constexpr std::uint32_t some = 16;
  const auto offset = static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(from) % some);
  team.forEach((size + offset + some - 1) / some, [&](std::uint32_t k) {
    std::uint8_t bytes[some];
    const std::uint32_t end = some * (k + 1) - offset;
    if ((k == 0 && offset > 0) || end > size) {
      for (std::uint32_t at = k == 0 ? 0 : end - some; at < end && at < size; ++at) team.add(&counts[from[at]], 1);
      return;
    }
#if defined(__CUDA_ARCH__)
    *reinterpret_cast<uint4*>(bytes) = *reinterpret_cast<const uint4*>(from + (end - some));
#else
    std::memcpy(bytes, from + (end - some), some);
#endif
    std::uint32_t run = 1;
    for (std::uint32_t j = 0; j < some; ++j) {
      if (j + 1 < some && bytes[j + 1] == bytes[j]) {
        ++run;
      } else {
        team.add(&counts[bytes[j]], run);
        run = 1;
      }
    }
  });
}

FUSE_FLOW_HD void putBytes(std::uint8_t*& to, std::uint64_t value, std::uint32_t bytes) {
  for (; bytes > 0; --bytes, value >>= 8) *to++ = static_cast<std::uint8_t>(value);
}

enum BlockType : std::uint32_t { kRawBlock, kRleBlock, kCompressedBlock };

FUSE_FLOW_HD void putBlockHeader(std::uint8_t*& to, bool last, BlockType type, std::uint32_t bytes) {
  putBytes(to, (last ? 1u : 0u) | type << 1 | bytes << 3, 3);
}

/** \brief All of a block before its streams. \returns whether it is smaller than the array */
FUSE_FLOW_HD bool writeHead(const PackWorkspace& work, std::uint32_t size, bool last, PackedArray& to) {
  if (work.tree_bytes == 0) return false;
  const bool four = work.streams == 4;
  const std::uint32_t literals = work.tree_bytes + (four ? 6u : 0u) + work.begin_of_stream[work.streams];
  // Both sizes have the same number of bits.
  const std::uint32_t format = !four ? 0u : size < 1u << 10 ? 1u : size < 1u << 14 ? 2u : 3u;
  const std::uint32_t bits = format < 2 ? 10 : format == 2 ? 14 : 18, header_bytes = (4 + 2 * bits + 7) / 8;
  const std::uint32_t block = header_bytes + literals + 1;  // and the number of sequences: 0
  if (block >= size) return false;
  std::uint8_t* at = to.head;
  putBlockHeader(at, last, kCompressedBlock, block);
  putBytes(
      at, 2u | format << 2 | static_cast<std::uint64_t>(size) << 4 | static_cast<std::uint64_t>(literals) << (4 + bits),
      header_bytes);
  for (std::uint32_t k = 0; k < work.tree_bytes; ++k) *at++ = work.tree[k];
  if (four)
    for (int k = 0; k < 3; ++k) putBytes(at, work.begin_of_stream[k + 1] - work.begin_of_stream[k], 2);
  to.kind = PackedArray::kPacked;
  to.head_bytes = static_cast<std::uint32_t>(at - to.head);
  to.body_bytes = work.begin_of_stream[work.streams] + 1;
  return true;
}

FUSE_FLOW_HD void store(std::uint32_t size, bool last, PackedArray& to) {
  std::uint8_t* at = to.head;
  putBlockHeader(at, last, kRawBlock, size);
  to.kind = PackedArray::kStored;
  to.head_bytes = 3;
  to.body_bytes = size;
}

FUSE_FLOW_HD void repeat(std::uint8_t byte, std::uint32_t size, bool last, PackedArray& to) {
  std::uint8_t* at = to.head;
  putBlockHeader(at, last, kRleBlock, size);
  putBytes(at, byte, 1);
  to.kind = PackedArray::kRepeated;
  to.head_bytes = 4;
  to.body_bytes = 0;
}

/** \brief The codes of a part, from a bit on. Words at its ends have bits of other parts. */
FUSE_FLOW_CALLS_ANY
template <typename Team>
FUSE_FLOW_HD void writePart(const Team& team, const std::uint8_t* from, const PackedPart& part,
                            const std::uint32_t* codes, std::uint32_t begin, std::uint32_t* body) {
  std::uint32_t* to = body + begin / 32;
  std::uint32_t count = begin % 32;
  bool shared = count > 0;
  std::uint64_t held = 0;
  forEachCode(from, part, codes, [&](std::uint32_t code) {
    held |= static_cast<std::uint64_t>(code & 0xffffu) << count;
    count += HuffmanCode::lengthOf(code);
    if (count < 32) return;
    if (shared) {
      team.setBits(to, static_cast<std::uint32_t>(held));
    } else {
      *to = static_cast<std::uint32_t>(held);
    }
    shared = false;
    ++to;
    held >>= 32;
    count -= 32;
  });
  if (count > 0) team.setBits(to, static_cast<std::uint32_t>(held));
}

}  // namespace detail

/** \brief Packs an array. \param size at most kMostBlockBytes; 0: there is no block  \param last whether it ends the frame
 *  \param body memory for as many bytes as the array has, and 8 more, in words */
FUSE_FLOW_CALLS_ANY
template <typename Team>
FUSE_FLOW_HD void packArray(const Team& team, PackWorkspace& work, const std::uint8_t* from, std::uint32_t size,
                            bool last, std::uint32_t* body, PackedArray& to) {
  constexpr std::uint32_t parts = PackWorkspace::kParts;
  if (size == 0) {
    team.once([&] {
      to.kind = PackedArray::kAbsent;
      to.head_bytes = to.body_bytes = 0;
    });
    return;
  }
  team.forEach(256, [&](std::uint32_t byte) { work.code.counts[byte] = 0; });
  team.once([&] { work.most = 0; });
  detail::countBytes(team, from, size, work.code.counts);
  team.forEach(256, [&](std::uint32_t byte) { team.raise(&work.most, work.code.counts[byte]); });
  if (work.most == size) {
    team.once([&] { detail::repeat(from[0], size, last, to); });
    return;
  }
  makeHuffmanCode(team, work.code);
  const std::uint32_t streams = size < 256 ? 1 : 4;
  team.forEach(parts, [&](std::uint32_t part) {
    std::uint32_t bits = 0;
    detail::forEachCode(from, {part, size, streams}, work.code.codes,
                        [&](std::uint32_t code) { bits += HuffmanCode::lengthOf(code); });
    work.bits[part] = bits;
  });
  const std::uint32_t all = team.sumUp(work.bits, parts);
  team.once([&] {
    work.streams = streams;
    work.begin_of_stream[0] = 0;
    for (std::uint32_t k = 0; k < streams; ++k) {
      const std::uint32_t next = k + 1 < streams ? work.bits[(k + 1) * (parts / streams)] : all;
      work.bits_of_stream[k] = next - work.bits[k * (parts / streams)];
      work.begin_of_stream[k + 1] =
          work.begin_of_stream[k] + work.bits_of_stream[k] / 8 + 1;  // with the bit that ends it
    }
    work.tree_bytes = writeHuffmanTree(work.code, work.coder, work.tree);
    if (!detail::writeHead(work, size, last, to)) detail::store(size, last, to);
  });
  if (to.kind != PackedArray::kPacked) return;
  team.forEach(to.body_bytes / 4 + 1, [&](std::uint32_t word) { body[word] = 0; });
  team.forEach(parts, [&](std::uint32_t number) {
    const detail::PackedPart part(number, size, streams);
    const std::uint32_t first_of_stream = part.stream * (parts / streams);
    const std::uint32_t begin = 8 * work.begin_of_stream[part.stream] + work.bits[number] - work.bits[first_of_stream];
    detail::writePart(team, from, part, work.code.codes, begin, body);
    if (number == first_of_stream) {
      const std::uint32_t end = 8 * work.begin_of_stream[part.stream] + work.bits_of_stream[part.stream];
      team.setBits(body + end / 32, 1u << end % 32);
    }
  });
}

}  // namespace fuse_flow::stream
