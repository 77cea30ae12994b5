#include "stream/codec/chunk_points.h"

#include "stream/codec/bits.h"
#include "stream/codec/layers.h"

#include <fuse_flow/stream/streamed_cloud.h>

namespace fuse_flow::stream {

namespace {

constexpr std::uint64_t kParts = 16;  // of the interval between two neighbours, each a token

/** \brief A number 0 … w − 1, in as few whole bits as that allows. */
void putTruncated(std::uint64_t value, std::uint64_t w, BitWriter& bits) {
  const int k = bitLength(w - 1);
  if (k == 0) return;
  const std::uint64_t u = (std::uint64_t{1} << k) - w;
  if (value < u) {
    bits.putLong(value, k - 1);
  } else {
    bits.putLong((value + u) >> 1, k - 1);
    bits.put((value + u) & 1, 1);
  }
}

std::uint64_t getTruncated(std::uint64_t w, BitReader& bits) {
  const int k = bitLength(w - 1);
  if (k == 0) return 0;
  const std::uint64_t u = (std::uint64_t{1} << k) - w;
  const std::uint64_t value = bits.getLong(k - 1);
  return value < u ? value : ((value << 1) | bits.get(1)) - u;
}

/** \brief A difference to the left neighbour alone. */
std::uint8_t putDifference(std::uint64_t d, BitWriter& bits) {
  const int n = bitLength(d);
  if (n < 2) return static_cast<std::uint8_t>(kParts + 2 * static_cast<unsigned>(n));
  const std::uint64_t second = d >> (n - 2) & 1;
  if (n > 2) bits.putLong(d & ((std::uint64_t{1} << (n - 2)) - 1), n - 2);
  return static_cast<std::uint8_t>(kParts + 2 * static_cast<unsigned>(n) + second);
}

std::uint64_t getDifference(std::uint8_t token, BitReader& bits) {
  const unsigned n = (token - kParts) / 2, second = token & 1;
  if (n < 2) return n;
  const std::uint64_t high = std::uint64_t{2} | second;
  return n > 2 ? high << (n - 2) | bits.getLong(static_cast<int>(n - 2)) : high;
}

std::uint8_t minus(std::uint8_t a, std::uint8_t b) { return static_cast<std::uint8_t>(a - b); }
std::uint8_t plus(std::uint8_t a, std::uint8_t b) { return static_cast<std::uint8_t>(a + b); }

/** \brief The arrays of a layer, where a layer of `points` points has them. */
template <typename Byte>
struct Arrays {
  Byte *tokens, *color[3], *confidence, *view_counts, *normal[2], *masks[8], *end;

  Arrays(Byte* begin, std::size_t points, std::uint32_t fields, int mask_bytes) {
    const auto take = [&](bool there) {
      Byte* const array = begin;
      if (there) begin += points;
      return array;
    };
    tokens = take(true);
    for (Byte*& array : color) array = take((fields & kColor) != 0);
    confidence = take((fields & kConfidence) != 0);
    view_counts = take((fields & kViewCount) != 0);
    for (Byte*& array : normal) array = take((fields & kNormal) != 0);
    for (int k = 0; k < 8; ++k) masks[k] = take((fields & kCameras) != 0 && k < mask_bytes);
    end = begin;
  }
};

std::size_t bytesOfPoint(std::uint32_t fields, int mask_bytes) {
  return 1 + ((fields & kColor) != 0 ? 3u : 0u) + ((fields & kConfidence) != 0 ? 1u : 0u) +
         ((fields & kViewCount) != 0 ? 1u : 0u) + ((fields & kNormal) != 0 ? 2u : 0u) +
         ((fields & kCameras) != 0 ? static_cast<std::size_t>(mask_bytes) : 0u);
}

/** \brief What the neighbours of a point say of it, for each of its fields. */
template <typename Visit>
void predict(const ChunkPoints& points, std::size_t i, std::size_t stride, bool has_right, std::uint32_t fields,
             const Visit& visit) {
  const bool has_left = i >= stride;
  const std::size_t left = has_left ? i - stride : i;  // of the first point of all: not read
  if (!has_left) {
    visit(Triple{}, 0, 0, std::array<std::uint8_t, 2>{}, std::uint64_t{0});
    return;
  }
  Triple color{};
  std::uint8_t confidence = 0, view_count = 0;
  std::size_t nearer = left;
  if (has_right) {
    const std::size_t right = i + stride;
    const Prediction prediction(points.positions[left], points.positions[i], points.positions[right]);
    if (!prediction.left_is_nearer) nearer = right;
    if (fields & kColor)
      for (std::size_t k = 0; k < 3; ++k)
        color[k] = prediction.between(points.colors[left][k], points.colors[right][k]);
    if (fields & kConfidence) confidence = prediction.between(points.confidence[left], points.confidence[right]);
    if (fields & kViewCount) view_count = prediction.between(points.view_counts[left], points.view_counts[right]);
  } else {
    if (fields & kColor) color = points.colors[left];
    if (fields & kConfidence) confidence = points.confidence[left];
    if (fields & kViewCount) view_count = points.view_counts[left];
  }
  visit(color, confidence, view_count, (fields & kNormal) ? points.normals[nearer] : std::array<std::uint8_t, 2>{},
        (fields & kCameras) ? points.masks[nearer] : std::uint64_t{0});
}

}  // namespace

void ChunkPoints::resize(std::size_t points, std::uint32_t fields) {
  codes.resize(points);
  positions.resize(points);
  colors.resize(fields & kColor ? points : 0);
  confidence.resize(fields & kConfidence ? points : 0);
  view_counts.resize(fields & kViewCount ? points : 0);
  normals.resize(fields & kNormal ? points : 0);
  masks.resize(fields & kCameras ? points : 0);
}

std::size_t mostLayerBytes(std::size_t points, std::uint32_t fields, int mask_bytes) {
  return points * (bytesOfPoint(fields, mask_bytes) + 8) + 8;
}

void writeLayer(const ChunkPoints& points, std::uint32_t fields, int mask_bytes, int layer, int layers,
                std::uint8_t* bytes, std::vector<std::size_t>& ends) {
  const Layer of(layer, layers);
  const std::size_t all = points.codes.size(), count = of.points(all), stride = of.stride;
  const Arrays<std::uint8_t> to(bytes, count, fields, mask_bytes);
  BitWriter bits(to.end);
  std::size_t k = 0;
  for (std::size_t i = of.first; i < all; i += of.between, ++k) {
    const std::uint64_t left = i >= stride ? points.codes[i - stride] : 0;
    const bool has_right = layer > 0 && i + stride < all;
    const std::uint64_t d = points.codes[i] - left;
    if (has_right) {
      const std::uint64_t interval = points.codes[i + stride] - left;
      if (interval >> 32 == 0) {  // as good as always; divided faster
        const std::uint32_t w = static_cast<std::uint32_t>(interval / kParts + 1);
        const std::uint32_t token = static_cast<std::uint32_t>(d) / w;
        to.tokens[k] = static_cast<std::uint8_t>(token);
        putTruncated(static_cast<std::uint32_t>(d) - token * w, w, bits);
      } else {
        const std::uint64_t w = interval / kParts + 1, token = d / w;
        to.tokens[k] = static_cast<std::uint8_t>(token);
        putTruncated(d - token * w, w, bits);
      }
    } else {
      to.tokens[k] = putDifference(d, bits);
    }
    predict(points, i, stride, has_right, fields,
            [&](const Triple& color, std::uint8_t confidence, std::uint8_t view_count,
                const std::array<std::uint8_t, 2>& normal, std::uint64_t mask) {
              if (fields & kColor) {
                const Triple& value = points.colors[i];
                Triple e;
                for (std::size_t part = 0; part < 3; ++part) e[part] = minus(value[part], color[part]);
                if (!points.chroma) e = {e[1], minus(e[0], e[1]), minus(e[2], e[1])};
                for (std::size_t part = 0; part < 3; ++part) to.color[part][k] = e[part];
              }
              if (fields & kConfidence) to.confidence[k] = minus(points.confidence[i], confidence);
              if (fields & kViewCount) to.view_counts[k] = minus(points.view_counts[i], view_count);
              if (fields & kNormal)
                for (std::size_t part = 0; part < 2; ++part)
                  to.normal[part][k] = minus(points.normals[i][part], normal[part]);
              if (fields & kCameras)
                for (int byte = 0; byte < mask_bytes; ++byte)
                  to.masks[byte][k] = static_cast<std::uint8_t>((points.masks[i] ^ mask) >> (8 * byte));
            });
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
  const std::size_t in_arrays = count * bytesOfPoint(fields, mask_bytes);
  if (size < in_arrays) throw FormatError("a frame of points: a layer has fewer bytes than its points need");
  const Arrays<const std::uint8_t> from(bytes, count, fields, mask_bytes);
  BitReader bits(bytes + in_arrays, size - in_arrays);
  constexpr std::uint64_t largest = (std::uint64_t{1} << (3 * kCoordinateBits)) - 1;
  std::size_t k = 0;
  for (std::size_t i = of.first; i < all; i += of.between, ++k) {
    const std::uint64_t left = i >= stride ? points.codes[i - stride] : 0;
    const bool has_right = layer > 0 && i + stride < all;
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
    predict(points, i, stride, has_right, fields,
            [&](const Triple& color, std::uint8_t confidence, std::uint8_t view_count,
                const std::array<std::uint8_t, 2>& normal, std::uint64_t mask) {
              if (fields & kColor) {
                Triple e{from.color[0][k], from.color[1][k], from.color[2][k]};
                if (!points.chroma) e = {plus(e[1], e[0]), e[0], plus(e[2], e[0])};
                for (std::size_t part = 0; part < 3; ++part) points.colors[i][part] = plus(e[part], color[part]);
              }
              if (fields & kConfidence) points.confidence[i] = plus(from.confidence[k], confidence);
              if (fields & kViewCount) points.view_counts[i] = plus(from.view_counts[k], view_count);
              if (fields & kNormal)
                for (std::size_t part = 0; part < 2; ++part)
                  points.normals[i][part] = plus(from.normal[part][k], normal[part]);
              if (fields & kCameras) {
                points.masks[i] = mask;
                for (int byte = 0; byte < mask_bytes; ++byte)
                  points.masks[i] ^= static_cast<std::uint64_t>(from.masks[byte][k]) << (8 * byte);
              }
            });
  }
  if (bits.overrun()) throw FormatError("a frame of points: a layer ends before its positions");
  if (bits.unread() > 0) throw FormatError("a frame of points: a layer has bytes that belong to nothing");
}

}  // namespace fuse_flow::stream
