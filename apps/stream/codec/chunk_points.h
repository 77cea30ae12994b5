#pragma once

#include "stream/codec/morton.h"
#include "stream/codec/values.h"

#include <cstdint>
#include <vector>

namespace fuse_flow::stream {

/** \brief The points of a chunk in their order. Arrays of fields that the frame has not are empty. */
struct ChunkPoints {
  std::vector<std::uint64_t> codes;  ///< Morton codes, increasing
  std::vector<Lattice> positions;
  std::vector<Triple> colors;  ///< r, g, b; or y, u, v, where chroma
  bool chroma{false};
  std::vector<std::uint8_t> confidence, view_counts;
  std::vector<std::array<std::uint8_t, 2>> normals;  ///< octahedral
  std::vector<std::uint64_t> masks;

  void resize(std::size_t points, std::uint32_t fields);
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
