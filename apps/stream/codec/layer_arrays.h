#pragma once

#include "stream/codec/layers.h"
#include "stream/codec/tokens.h"
#include "stream/codec/values.h"

#include <fuse_flow/stream/encoded_frame.h>

#include <cstddef>
#include <cstdint>

namespace fuse_flow::stream {

/** \brief The arrays of a layer, where a layer of `points` points has them. */
template <typename Byte>
struct LayerArrays {
  Byte *tokens, *color[3], *confidence, *view_counts, *normal[2], *masks[8], *end;

  FUSE_FLOW_HD LayerArrays(Byte* begin, std::size_t points, std::uint32_t fields, int mask_bytes) {
    tokens = take(begin, points, true);
    for (int k = 0; k < 3; ++k) color[k] = take(begin, points, (fields & kColor) != 0);
    confidence = take(begin, points, (fields & kConfidence) != 0);
    view_counts = take(begin, points, (fields & kViewCount) != 0);
    for (int k = 0; k < 2; ++k) normal[k] = take(begin, points, (fields & kNormal) != 0);
    for (int k = 0; k < 8; ++k) masks[k] = take(begin, points, (fields & kCameras) != 0 && k < mask_bytes);
    end = begin;
  }

 private:
  FUSE_FLOW_HD static Byte* take(Byte*& begin, std::size_t points, bool there) {
    Byte* const array = begin;
    if (there) begin += points;
    return array;
  }
};

FUSE_FLOW_HD std::size_t arraysOf(std::uint32_t fields, int mask_bytes) {
  return 1 + ((fields & kColor) != 0 ? 3u : 0u) + ((fields & kConfidence) != 0 ? 1u : 0u) +
         ((fields & kViewCount) != 0 ? 1u : 0u) + ((fields & kNormal) != 0 ? 2u : 0u) +
         ((fields & kCameras) != 0 ? static_cast<std::size_t>(mask_bytes) : 0u);
}

/** \brief Where a point stands in its chunk, and what its neighbours say of it. */
struct Place {
  std::size_t rank, stride;
  bool has_right;
  std::uint32_t weight{16};  ///< of the left neighbour, of 16; the rest is the right one's
  std::size_t nearer{0};     ///< the rank of the nearer neighbour

  /** \tparam Points has position(rank) */
  FUSE_FLOW_CALLS_ANY
  template <typename Points>
  FUSE_FLOW_HD Place(const Points& points, std::size_t rank_of_point, std::size_t stride_of_layer, bool has_right_one)
      : rank(rank_of_point), stride(stride_of_layer), has_right(has_right_one) {
    if (!hasLeft()) return;
    nearer = left();
    if (!has_right) return;
    const Prediction prediction(points.position(left()), points.position(rank), points.position(right()));
    weight = prediction.left;
    if (!prediction.left_is_nearer) nearer = right();
  }

  FUSE_FLOW_HD bool hasLeft() const { return rank >= stride; }
  FUSE_FLOW_HD std::size_t left() const { return rank - stride; }
  FUSE_FLOW_HD std::size_t right() const { return rank + stride; }

  /** \param value that of a rank, a byte */
  FUSE_FLOW_CALLS_ANY
  template <typename Value>
  FUSE_FLOW_HD std::uint8_t between(const Value& value) const {
    if (!hasLeft()) return 0;
    if (!has_right) return value(left());
    return static_cast<std::uint8_t>((weight * value(left()) + (16 - weight) * value(right()) + 8) >> 4);
  }
};

FUSE_FLOW_HD std::uint8_t minus(std::uint8_t a, std::uint8_t b) { return static_cast<std::uint8_t>(a - b); }

/** \brief The color that the neighbours predict. \tparam Points has color(rank) */
FUSE_FLOW_CALLS_ANY
template <typename Points>
FUSE_FLOW_HD Triple predictedColor(const Points& points, const Place& place) {
  Triple color{};
  for (std::size_t part = 0; part < 3; ++part)
    color[part] = place.between([&](std::size_t rank) { return points.color(rank)[part]; });
  return color;
}

/** \brief Writes the k-th point of a layer into its arrays. \tparam Points code(rank), and so on: see ChunkPoints
 *  \returns its token, and the bits that go among the raw ones */
FUSE_FLOW_CALLS_ANY
template <typename Points>
FUSE_FLOW_HD Token writePoint(const Points& points, const Place& place, std::uint32_t fields, int mask_bytes,
                              bool chroma, std::size_t k, const LayerArrays<std::uint8_t>& to) {
  const std::size_t i = place.rank;
  const std::uint64_t left = place.hasLeft() ? points.code(place.left()) : 0;
  const std::uint64_t d = points.code(i) - left;
  const Token token = place.has_right ? tokenBetween(d, points.code(place.right()) - left) : tokenAfter(d);
  to.tokens[k] = static_cast<std::uint8_t>(token.token);
  if (fields & kColor) {
    const Triple value = points.color(i), guess = predictedColor(points, place);
    Triple e{};
    for (std::size_t part = 0; part < 3; ++part) e[part] = minus(value[part], guess[part]);
    if (!chroma) e = {{e[1], minus(e[0], e[1]), minus(e[2], e[1])}};
    for (std::size_t part = 0; part < 3; ++part) to.color[part][k] = e[part];
  }
  if (fields & kConfidence)
    to.confidence[k] =
        minus(points.confidence(i), place.between([&](std::size_t rank) { return points.confidence(rank); }));
  if (fields & kViewCount)
    to.view_counts[k] =
        minus(points.viewCount(i), place.between([&](std::size_t rank) { return points.viewCount(rank); }));
  if (fields & kNormal) {
    const Octahedral guess = place.hasLeft() ? points.normal(place.nearer) : Octahedral{};
    for (std::size_t part = 0; part < 2; ++part) to.normal[part][k] = minus(points.normal(i)[part], guess[part]);
  }
  if (fields & kCameras) {
    const std::uint64_t difference = points.mask(i) ^ (place.hasLeft() ? points.mask(place.nearer) : 0);
    for (int byte = 0; byte < mask_bytes; ++byte)
      to.masks[byte][k] = static_cast<std::uint8_t>(difference >> (8 * byte));
  }
  return token;
}

}  // namespace fuse_flow::stream
