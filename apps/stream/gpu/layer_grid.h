#pragma once

#include "stream/codec/layer_arrays.h"
#include "stream/gpu/packed_array.h"

#include <cstddef>
#include <cstdint>

namespace fuse_flow::stream {

/** \brief Of a point in the order of its frame: its chunk, its layer, and where it is in both. */
struct PlaceInLayer {
  std::uint32_t chunk, rank, layer;
  std::uint32_t number;  ///< in its layer
};

/** \brief Where everything lies that is known of a frame's layers before they are packed: in the order of their chunks, and of the layers
 *  in a chunk. */
struct LayerGrid {
  std::uint32_t points, chunk_points, chunks, layers;
  std::uint32_t fields;
  int mask_bytes, chroma_step;
  std::uint32_t arrays;    ///< of a layer, without the raw bits
  std::uint32_t blocks;    ///< of a layer that are packed each by itself, some of them empty
  std::uint32_t raw_from;  ///< the first of those that have raw bits

  LayerGrid(std::uint32_t all_points, std::uint32_t of_chunk, std::uint32_t of_layers, std::uint32_t of_fields,
            int bytes_of_mask, int step_of_chroma)
      : points(all_points),
        chunk_points(of_chunk),
        chunks((all_points + of_chunk - 1) / of_chunk),
        layers(of_layers),
        fields(of_fields),
        mask_bytes(bytes_of_mask),
        chroma_step(step_of_chroma),
        arrays(static_cast<std::uint32_t>(arraysOf(of_fields, bytes_of_mask))) {
    raw_from = arrays - ((fields & kColor) != 0 ? 1 : 0);  // two of the three that colour has are one block
    const std::size_t most = of_layers == 1 ? of_chunk : (of_chunk + 1) / 2;  // points of a layer
    blocks = raw_from + static_cast<std::uint32_t>((8 * most + kMostBlockBytes - 1) / kMostBlockBytes);
  }

  FUSE_FLOW_HD std::uint32_t pointsOfChunk(std::uint32_t chunk) const {
    const std::uint32_t left = points - chunk * chunk_points;
    return left < chunk_points ? left : chunk_points;
  }
  FUSE_FLOW_HD std::uint32_t frames() const { return chunks * layers; }
  FUSE_FLOW_HD std::uint32_t frame(std::uint32_t chunk, std::uint32_t layer) const { return chunk * layers + layer; }
  FUSE_FLOW_HD Layer layerOf(std::uint32_t frame) const {
    return {static_cast<int>(frame % layers), static_cast<int>(layers)};
  }
  FUSE_FLOW_HD std::uint32_t pointsOfLayer(std::uint32_t frame) const {
    return static_cast<std::uint32_t>(layerOf(frame).points(pointsOfChunk(frame / layers)));
  }
  /** \brief Points before those of a layer. */
  FUSE_FLOW_HD std::uint32_t firstPoint(std::uint32_t frame) const {
    const std::uint32_t chunk = frame / layers;
    if (chunk == chunks) return points;
    return chunk * chunk_points +
           static_cast<std::uint32_t>(
               pointsUpTo(pointsOfChunk(chunk), static_cast<int>(frame % layers), static_cast<int>(layers)));
  }
  FUSE_FLOW_HD PlaceInLayer placeOf(std::uint32_t point) const {
    PlaceInLayer place{};
    place.chunk = point / chunk_points;
    place.rank = point % chunk_points;
    const std::uint32_t sparsest = layers - 1;  // the stride's logarithm
    std::uint32_t zeros = 0;
    while (zeros < sparsest && (place.rank >> zeros & 1) == 0) ++zeros;
    place.layer = sparsest - zeros;
    // Every stride-th of layer 0; later ones have every second one of those.
    place.number = place.layer == 0 ? place.rank >> sparsest : place.rank >> (zeros + 1);
    return place;
  }

  ///@{
  /** \brief Where the bytes of a layer begin before and after they are packed; of frames(): where the memory ends. Each begins a line of
   *  memory, as the checksum reads words of eight bytes, and those who pack may read sixteen. */
  FUSE_FLOW_HD std::size_t firstByte(std::uint32_t frame) const { return aligned(bytesBefore(frame)) + kLine * frame; }
  FUSE_FLOW_HD std::size_t firstPackedByte(std::uint32_t frame) const {
    return aligned(bytesBefore(frame)) + std::size_t{2 * kLine} * (blocks + 1) * frame;
  }
  ///@}
  FUSE_FLOW_HD static std::size_t aligned(std::size_t bytes) { return (bytes + kLine - 1) / kLine * kLine; }
  static constexpr std::uint32_t kLine = 64;

 private:
  FUSE_FLOW_HD std::size_t bytesBefore(std::uint32_t frame) const {
    return std::size_t{firstPoint(frame)} * (arrays + 8) + std::size_t{8} * frame;
  }
};

/** \brief An array of a layer that is packed by itself. */
struct LayerBlock {
  std::size_t first{0};    ///< in the layer, bytes
  std::uint32_t bytes{0};  ///< 0: there is none
  bool last{false};        ///< of the layer

  /** \param points of the layer  \param raw_bytes after its arrays */
  FUSE_FLOW_HD LayerBlock(const LayerGrid& grid, std::uint32_t block, std::uint32_t points, std::uint32_t raw_bytes) {
    if (points == 0) return;
    if (block >= grid.raw_from) {
      const std::uint32_t before = (block - grid.raw_from) * kMostBlockBytes;
      first = std::size_t{grid.arrays} * points + before;
      if (before >= raw_bytes) return;
      const std::uint32_t left = raw_bytes - before;
      bytes = left < kMostBlockBytes ? left : kMostBlockBytes;
      last = left <= kMostBlockBytes;
      return;
    }
    // Tokens, green, and the two differences of colour, which are alike; then the others.
    const bool color = (grid.fields & kColor) != 0;
    const std::uint32_t array = color && block > 2 ? block + 1 : block;
    first = std::size_t{array} * points;
    bytes = color && block == 2 ? 2 * points : points;
    last = raw_bytes == 0 && block + 1 == grid.raw_from;
  }
};

}  // namespace fuse_flow::stream
