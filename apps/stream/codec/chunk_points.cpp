#include "stream/codec/chunk_points.h"

#include "stream/codec/bits.h"

#include <fuse_flow/stream/streamed_cloud.h>

namespace fuse_flow::stream {

namespace {

std::uint64_t getTruncated(std::uint64_t w, BitReader& bits) {
  const int k = bitLength(w - 1);
  if (k == 0) return 0;
  const std::uint64_t u = (std::uint64_t{1} << k) - w;
  const std::uint64_t value = bits.getLong(k - 1);
  return value < u ? value : ((value << 1) | bits.get(1)) - u;
}

std::uint64_t getDifference(std::uint8_t token, BitReader& bits) {
  const unsigned n = (token - kParts) / 2, second = token & 1;
  if (n < 2) return n;
  const std::uint64_t high = std::uint64_t{2} | second;
  return n > 2 ? high << (n - 2) | bits.getLong(static_cast<int>(n - 2)) : high;
}

std::uint8_t plus(std::uint8_t a, std::uint8_t b) { return static_cast<std::uint8_t>(a + b); }

}  // namespace

void ChunkPoints::resize(std::size_t points, std::uint32_t fields) {
  codes.resize(points);
  positions.resize(points);
  colors.resize(fields & kColor ? points : 0);
  confidences.resize(fields & kConfidence ? points : 0);
  view_counts.resize(fields & kViewCount ? points : 0);
  normals.resize(fields & kNormal ? points : 0);
  masks.resize(fields & kCameras ? points : 0);
}

std::size_t mostLayerBytes(std::size_t points, std::uint32_t fields, int mask_bytes) {
  return points * (arraysOf(fields, mask_bytes) + 8) + 8;
}

void writeLayer(const ChunkPoints& points, std::uint32_t fields, int mask_bytes, int layer, int layers,
                std::uint8_t* bytes, std::vector<std::size_t>& ends) {
  const Layer of(layer, layers);
  const std::size_t all = points.codes.size(), count = of.points(all);
  const LayerArrays<std::uint8_t> to(bytes, count, fields, mask_bytes);
  BitWriter bits(to.end);
  std::size_t k = 0;
  for (std::size_t i = of.first; i < all; i += of.between, ++k) {
    const Place place(points, i, of.stride, layer > 0 && i + of.stride < all);
    const Token token = writePoint(points, place, fields, mask_bytes, points.chroma, k, to);
    bits.putLong(token.bits, token.count);
  }
  ends.clear();
  for (std::uint8_t* end = bytes + count; end <= to.end; end += count)
    // The two differences of colour are alike.
    if ((fields & kColor) == 0 || end != to.color[2]) ends.push_back(static_cast<std::size_t>(end - bytes));
  ends.push_back(static_cast<std::size_t>(bits.end() - bytes));
}

void readLayer(const std::uint8_t* bytes, std::size_t size, std::uint32_t fields, int mask_bytes, int layer, int layers,
               ChunkPoints& points) {
  const Layer of(layer, layers);
  const std::size_t all = points.codes.size(), count = of.points(all), stride = of.stride;
  const std::size_t in_arrays = count * arraysOf(fields, mask_bytes);
  if (size < in_arrays) throw FormatError("a frame of points: a layer has fewer bytes than its points need");
  const LayerArrays<const std::uint8_t> from(bytes, count, fields, mask_bytes);
  BitReader bits(bytes + in_arrays, size - in_arrays);
  constexpr std::uint64_t largest = (std::uint64_t{1} << (3 * kCoordinateBits)) - 1;
  std::size_t k = 0;
  for (std::size_t i = of.first; i < all; i += of.between, ++k) {
    const bool has_left = i >= stride, has_right = layer > 0 && i + stride < all;
    const std::uint64_t left = has_left ? points.codes[i - stride] : 0;
    const std::uint8_t token = from.tokens[k];
    std::uint64_t d;
    if (has_right) {
      const std::uint64_t interval = points.codes[i + stride] - left, w = interval / kParts + 1;
      if (token >= kParts) throw FormatError("a frame of points: a position that has two neighbours lies outside them");
      d = token * w + getTruncated(w, bits);
      if (d > interval) throw FormatError("a frame of points: a position lies behind its right neighbour");
    } else {
      if (token < kParts || token > kParts + 2 * (3 * kCoordinateBits) + 1)
        throw FormatError("a frame of points: a position has no meaning");
      d = getDifference(token, bits);
      if (d > largest - left) throw FormatError("a frame of points: a position lies outside the lattice");
    }
    points.codes[i] = left + d;
    points.positions[i] = fromMortonCode(points.codes[i]);
    const Place place(points, i, stride, has_right);
    if (fields & kColor) {
      const Triple guess = predictedColor(points, place);
      Triple e{{from.color[0][k], from.color[1][k], from.color[2][k]}};
      if (!points.chroma) e = {{plus(e[1], e[0]), e[0], plus(e[2], e[0])}};
      for (std::size_t part = 0; part < 3; ++part) points.colors[i][part] = plus(e[part], guess[part]);
    }
    if (fields & kConfidence)
      points.confidences[i] =
          plus(from.confidence[k], place.between([&](std::size_t rank) { return points.confidences[rank]; }));
    if (fields & kViewCount)
      points.view_counts[i] =
          plus(from.view_counts[k], place.between([&](std::size_t rank) { return points.view_counts[rank]; }));
    if (fields & kNormal) {
      const Octahedral guess = has_left ? points.normals[place.nearer] : Octahedral{};
      for (std::size_t part = 0; part < 2; ++part) points.normals[i][part] = plus(from.normal[part][k], guess[part]);
    }
    if (fields & kCameras) {
      points.masks[i] = has_left ? points.masks[place.nearer] : 0;
      for (int byte = 0; byte < mask_bytes; ++byte)
        points.masks[i] ^= static_cast<std::uint64_t>(from.masks[byte][k]) << (8 * byte);
    }
  }
  if (bits.overrun()) throw FormatError("a frame of points: a layer ends before its positions");
  if (bits.unread() > 0) throw FormatError("a frame of points: a layer has bytes that belong to nothing");
}

}  // namespace fuse_flow::stream
