#pragma once

#include "stream/gpu/content_checksum.h"
#include "stream/gpu/layer_grid.h"
#include "stream/gpu/point_steps.h"

#include <cstdint>

/** \file
 *  \brief From points in their order to the bytes of layers. */

namespace fuse_flow::stream {

/** \brief The points of a chunk, see layer_arrays.h. Nothing writes what they are while they are read. */
struct ChunkInOrder {
  const std::uint64_t* codes;
  const PackedValues* all_values;
  const std::uint64_t* masks;

  FUSE_FLOW_HD std::uint64_t code(std::size_t rank) const { return load(codes + rank); }
  FUSE_FLOW_HD Lattice position(std::size_t rank) const { return fromMortonCode(code(rank)); }
  FUSE_FLOW_HD Triple color(std::size_t rank) const {
    const PackedValues of = values(rank);
    return {{of.byte(0), of.byte(1), of.byte(2)}};
  }
  FUSE_FLOW_HD std::uint8_t confidence(std::size_t rank) const { return values(rank).byte(3); }
  FUSE_FLOW_HD std::uint8_t viewCount(std::size_t rank) const { return values(rank).byte(4); }
  FUSE_FLOW_HD Octahedral normal(std::size_t rank) const {
    const PackedValues of = values(rank);
    return {{of.byte(5), of.byte(6)}};
  }
  FUSE_FLOW_HD std::uint64_t mask(std::size_t rank) const { return load(masks + rank); }

 private:
  FUSE_FLOW_HD PackedValues values(std::size_t rank) const { return {load(&all_values[rank].word)}; }
  FUSE_FLOW_HD static std::uint64_t load(const std::uint64_t* from) {
#if defined(__CUDA_ARCH__)
    return __ldg(reinterpret_cast<const unsigned long long*>(from));
#else
    return *from;
#endif
  }
};

/** \brief A point into the arrays of its layer. Its bits are kept until it is known where they go. */
struct WritePoint {
  LayerGrid grid;
  ChunkInOrder points;  ///< all of them
  std::uint8_t* bytes;
  std::uint64_t* bits;        ///< of each point, in the order of the layers
  std::uint32_t* bit_counts;  ///< likewise

  FUSE_FLOW_HD void operator()(std::uint32_t i) const {
    const PlaceInLayer at = grid.placeOf(i);
    const std::uint32_t frame = grid.frame(at.chunk, at.layer), of_layer = grid.pointsOfLayer(frame);
    const LayerArrays<std::uint8_t> arrays(bytes + grid.firstByte(frame), of_layer, grid.fields, grid.mask_bytes);
    const std::size_t first = std::size_t{at.chunk} * grid.chunk_points;
    const ChunkInOrder chunk{points.codes + first, points.all_values + first,
                             points.masks + ((grid.fields & kCameras) != 0 ? first : 0)};
    const std::uint32_t stride = 1u << (grid.layers - 1 - at.layer);
    const Place place(chunk, at.rank, stride, at.layer > 0 && at.rank + stride < grid.pointsOfChunk(at.chunk));
    const Token token = writePoint(chunk, place, grid.fields, grid.mask_bytes, grid.chroma_step > 0, at.number, arrays);
    const std::uint32_t in_order = grid.firstPoint(frame) + at.number;
    bits[in_order] = token.bits;
    bit_counts[in_order] = static_cast<std::uint32_t>(token.count);
  }
};

/** \brief How many bits come before a point in its layer. The sums of all layers may go beyond 2³²; their differences do not. */
struct RawBits {
  const std::uint32_t* sums;

  FUSE_FLOW_HD std::uint32_t bytes(const LayerGrid& grid, std::uint32_t frame) const {
    return (sums[grid.firstPoint(frame + 1)] - sums[grid.firstPoint(frame)] + 7) / 8;
  }
};

/** \brief The bits of a point to where they belong. */
struct PutBits {
  LayerGrid grid;
  const std::uint64_t* bits;
  RawBits raw;
  std::uint8_t* bytes;

  FUSE_FLOW_HD void operator()(std::uint32_t i) const {
    const PlaceInLayer at = grid.placeOf(i);
    const std::uint32_t frame = grid.frame(at.chunk, at.layer), first = grid.firstPoint(frame);
    const std::uint64_t value = bits[first + at.number];
    if (value == 0) return;
    const std::size_t begin = 8 * (grid.firstByte(frame) + std::size_t{grid.arrays} * grid.pointsOfLayer(frame)) +
                              (raw.sums[first + at.number] - raw.sums[first]);
    auto* word = reinterpret_cast<std::uint32_t*>(bytes) + begin / 32;
    const auto shift = static_cast<std::uint32_t>(begin % 32);
    const std::uint64_t low = value << shift;
    put(word, static_cast<std::uint32_t>(low));
    put(word + 1, static_cast<std::uint32_t>(low >> 32));
    if (shift > 0) put(word + 2, static_cast<std::uint32_t>(value >> (64 - shift)));
  }

 private:
  FUSE_FLOW_HD static void put(std::uint32_t* word, std::uint32_t value) {
    if (value != 0) gpu::atomicOrTo(word, value);
  }
};

/** \brief A team for each block of each layer, and before them one for its checksum, which takes longest. */
struct PackLayers {
  struct Shared {
    PackWorkspace work;
    std::uint64_t lanes[4];
  };

  LayerGrid grid;
  RawBits raw;
  const std::uint8_t* bytes;
  std::uint8_t* packed;
  PackedArray* arrays;       ///< of each layer grid.blocks
  std::uint32_t* checksums;  ///< of each layer
  std::uint32_t* sizes;      ///< of each block: what goes out

  static constexpr std::uint32_t kFrameHeader = 6, kFrameChecksum = 4;

  FUSE_FLOW_HD std::uint32_t teams() const { return grid.frames() * (grid.blocks + 1); }

  FUSE_FLOW_CALLS_ANY
  template <typename Team>
  FUSE_FLOW_HD void operator()(const Team& team, std::uint32_t number, Shared& shared) const {
    const std::uint32_t frames = grid.frames(), frame = number % frames;
    const std::uint32_t points = grid.pointsOfLayer(frame), raw_bytes = raw.bytes(grid, frame);
    const std::uint8_t* from = bytes + grid.firstByte(frame);
    if (number < frames) {
      if (points > 0) contentChecksum(team, shared.lanes, from, points * grid.arrays + raw_bytes, checksums + frame);
      return;
    }
    const std::uint32_t block = number / frames - 1;
    const LayerBlock part(grid, block, points, raw_bytes);
    PackedArray& to = arrays[frame * grid.blocks + block];
    packArray(team, shared.work, from + part.first, part.bytes, part.last, body(frame, block, part), to);
    team.once([&] {
      std::uint32_t size = to.head_bytes + to.body_bytes;
      if (points > 0 && block == 0) size += kFrameHeader;
      if (points > 0 && block + 1 == grid.blocks) size += kFrameChecksum;
      sizes[frame * grid.blocks + block] = size;
    });
  }

  /** \brief Where the streams of a block are. A block is smaller than what it holds. */
  FUSE_FLOW_HD std::uint32_t* body(std::uint32_t frame, std::uint32_t block, const LayerBlock& part) const {
    return reinterpret_cast<std::uint32_t*>(packed + grid.firstPackedByte(frame) + LayerGrid::aligned(part.first) +
                                            std::size_t{2 * LayerGrid::kLine} * block);
  }
};

/** \brief Copies bytes that lie anywhere. Some at a time are on their way from memory. */
FUSE_FLOW_CALLS_ANY
template <typename Team>
FUSE_FLOW_HD void copyBytes(const Team& team, const std::uint8_t* from, std::uint32_t size, std::uint8_t* to) {
  constexpr std::uint32_t some = 8;
  team.forEach((size + some - 1) / some, [&](std::uint32_t k) {
    std::uint8_t bytes[some];
    const std::uint32_t begin = some * k, count = size - begin < some ? size - begin : some;
    for (std::uint32_t j = 0; j < some; ++j) bytes[j] = j < count ? from[begin + j] : std::uint8_t{0};
    for (std::uint32_t j = 0; j < some; ++j)
      if (j < count) to[begin + j] = bytes[j];
  });
}

/** \brief What was packed, together: a team for each block. */
struct JoinBlocks {
  struct Shared {};

  PackLayers from;
  const std::uint32_t* begins;  ///< of each block
  std::uint8_t* to;

  FUSE_FLOW_CALLS_ANY
  template <typename Team>
  FUSE_FLOW_HD void operator()(const Team& team, std::uint32_t number, Shared&) const {
    const LayerGrid& grid = from.grid;
    const std::uint32_t frame = number / grid.blocks, block = number % grid.blocks;
    const std::uint32_t points = grid.pointsOfLayer(frame);
    if (points == 0) return;
    const LayerBlock part(grid, block, points, from.raw.bytes(grid, frame));
    const PackedArray& array = from.arrays[number];
    std::uint8_t* at = to + begins[number];
    if (block == 0) {
      // The magic number; a frame of any size with a checksum; a window of 128 KB.
      team.once([&] {
        const std::uint8_t header[PackLayers::kFrameHeader] = {0x28, 0xb5, 0x2f, 0xfd, 0x04, 0x38};
        for (std::uint32_t k = 0; k < PackLayers::kFrameHeader; ++k) at[k] = header[k];
      });
      at += PackLayers::kFrameHeader;
    }
    copyBytes(team, array.head, array.head_bytes, at);
    at += array.head_bytes;
    const std::uint8_t* body = array.kind == PackedArray::kStored
                                   ? from.bytes + grid.firstByte(frame) + part.first
                                   : reinterpret_cast<const std::uint8_t*>(from.body(frame, block, part));
    copyBytes(team, body, array.body_bytes, at);
    at += array.body_bytes;
    if (block + 1 == grid.blocks)
      team.forEach(PackLayers::kFrameChecksum,
                   [&](std::uint32_t k) { at[k] = static_cast<std::uint8_t>(from.checksums[frame] >> (8 * k)); });
  }
};

}  // namespace fuse_flow::stream
