#pragma once

#include "stream/codec/layer_arrays.h"

#include <cstdint>
#include <vector>

namespace fuse_flow::stream {

/** \brief The points of a chunk in their order. Arrays of fields that the frame has not are empty. */
struct ChunkPoints {
  std::vector<std::uint64_t> codes;  ///< Morton codes, increasing
  std::vector<Lattice> positions;
  std::vector<Triple> colors;  ///< r, g, b; or y, u, v, where chroma
  bool chroma{false};
  std::vector<std::uint8_t> confidences, view_counts;
  std::vector<Octahedral> normals;
  std::vector<std::uint64_t> masks;

  void resize(std::size_t points, std::uint32_t fields);

  ///@{
  /** \brief Of a point, as layer_arrays.h asks for it. */
  std::uint64_t code(std::size_t rank) const { return codes[rank]; }
  const Lattice& position(std::size_t rank) const { return positions[rank]; }
  const Triple& color(std::size_t rank) const { return colors[rank]; }
  std::uint8_t confidence(std::size_t rank) const { return confidences[rank]; }
  std::uint8_t viewCount(std::size_t rank) const { return view_counts[rank]; }
  const Octahedral& normal(std::size_t rank) const { return normals[rank]; }
  std::uint64_t mask(std::size_t rank) const { return masks[rank]; }
  ///@}
};

/** \brief One layer of the points, as it is before Zstandard. \param bytes memory for it, of mostLayerBytes()
 *  \param ends filled with where each of its arrays ends; what is alike is compressed together */
void writeLayer(const ChunkPoints& points, std::uint32_t fields, int mask_bytes, int layer, int layers,
                std::uint8_t* bytes, std::vector<std::size_t>& ends);

/** \brief Fills in the ranks of one layer; those of the layers before it are there. \throws FormatError */
void readLayer(const std::uint8_t* bytes, std::size_t size, std::uint32_t fields, int mask_bytes, int layer, int layers,
               ChunkPoints& points);

/** \brief The most bytes that a layer of so many points can have. */
std::size_t mostLayerBytes(std::size_t points, std::uint32_t fields, int mask_bytes);

}  // namespace fuse_flow::stream
