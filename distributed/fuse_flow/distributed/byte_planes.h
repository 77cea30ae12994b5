#pragma once

#include <fuse_flow/distributed/communicator.h>

#include <cstdint>
#include <cstring>

namespace fuse_flow {
namespace distributed {

/** \brief What the bytes of a part of a message are, which says how neighbours are alike. */
enum class ByteKind : std::uint8_t {
  Any,     ///< nothing is known
  Words,   ///< records of 32-bit words: floats of an image, points
  Colors,  ///< red, green, blue
};

/** \brief Orders bytes so that what is alike lies together, for a codec that looks for repetitions; without loss.
 *
 *  Words: the difference to the same word of the record before, as a signed integer (floats that are near have bits that are near), folded so
 *  that small ones of both signs have zeros in front; then all first bytes, all second bytes, and so on. Colours: the differences of red and
 *  blue to green, each of it to the pixel before; then all of one kind together. Bytes that do not make a whole record at the end stay. */
class BytePlanes {
 public:
  /** \param record words of a record, for ByteKind::Words; > 0 */
  BytePlanes(ByteKind kind, std::uint32_t record) : kind_(kind), record_(record) {}

  /** \brief n bytes in the other order. The two do not overlap. */
  void order(const char* from, std::size_t n, char* to) const {
    std::size_t whole = 0;
    if (kind_ == ByteKind::Words) whole = orderWords(from, n, to);
    if (kind_ == ByteKind::Colors) whole = orderColors(from, n, to);
    if (n > whole) std::memcpy(to + whole, from + whole, n - whole);
  }

  /** \brief The inverse of order(). */
  void restore(const char* from, std::size_t n, char* to) const {
    std::size_t whole = 0;
    if (kind_ == ByteKind::Words) whole = restoreWords(from, n, to);
    if (kind_ == ByteKind::Colors) whole = restoreColors(from, n, to);
    if (n > whole) std::memcpy(to + whole, from + whole, n - whole);
  }

 private:
  static std::uint32_t load(const char* from) {
    std::uint32_t word;
    std::memcpy(&word, from, sizeof word);
    return word;
  }
  static std::uint32_t fold(std::uint32_t difference) { return difference << 1 ^ (0u - (difference >> 31)); }
  static std::uint32_t unfold(std::uint32_t folded) { return folded >> 1 ^ (0u - (folded & 1)); }

  /** \brief Word by word of the record: so each has its four planes, and its neighbours are the same word's. */
  std::size_t orderWords(const char* from, std::size_t n, char* to) const {
    const std::size_t stride = record_ * sizeof(std::uint32_t), records = n / stride;
    if (records == 0) return 0;  // a message may say that records are long
    for (std::size_t w = 0; w < record_; ++w, to += records * sizeof(std::uint32_t)) {
      const char* word = from + w * sizeof(std::uint32_t);
      std::uint32_t before = 0;
      for (std::size_t k = 0; k < records; ++k, word += stride) {
        const std::uint32_t value = load(word), folded = fold(value - before);
        before = value;
        for (std::size_t p = 0; p < 4; ++p) to[p * records + k] = static_cast<char>(folded >> 8 * p);
      }
    }
    return records * stride;
  }
  std::size_t restoreWords(const char* from, std::size_t n, char* to) const {
    const std::size_t stride = record_ * sizeof(std::uint32_t), records = n / stride;
    if (records == 0) return 0;
    for (std::size_t w = 0; w < record_; ++w, from += records * sizeof(std::uint32_t)) {
      char* word = to + w * sizeof(std::uint32_t);
      std::uint32_t value = 0;
      for (std::size_t k = 0; k < records; ++k, word += stride) {
        std::uint32_t folded = 0;
        for (std::size_t p = 0; p < 4; ++p)
          folded |= static_cast<std::uint32_t>(static_cast<unsigned char>(from[p * records + k])) << 8 * p;
        value += unfold(folded);
        std::memcpy(word, &value, sizeof value);
      }
    }
    return records * stride;
  }

  static std::size_t orderColors(const char* from, std::size_t n, char* to) {
    const std::size_t pixels = n / 3;
    int red = 0, green = 0, blue = 0;  // of the pixel before, red and blue less green
    for (std::size_t k = 0; k < pixels; ++k, from += 3) {
      const int g = from[1], r = from[0] - g, b = from[2] - g;
      to[k] = static_cast<char>(r - red);
      to[pixels + k] = static_cast<char>(g - green);
      to[2 * pixels + k] = static_cast<char>(b - blue);
      red = r;
      green = g;
      blue = b;
    }
    return pixels * 3;
  }
  static std::size_t restoreColors(const char* from, std::size_t n, char* to) {
    const std::size_t pixels = n / 3;
    unsigned int red = 0, green = 0, blue = 0;
    for (std::size_t k = 0; k < pixels; ++k, to += 3) {
      red += static_cast<unsigned char>(from[k]);
      green += static_cast<unsigned char>(from[pixels + k]);
      blue += static_cast<unsigned char>(from[2 * pixels + k]);
      to[0] = static_cast<char>(red + green);
      to[1] = static_cast<char>(green);
      to[2] = static_cast<char>(blue + green);
    }
    return pixels * 3;
  }

  ByteKind kind_;
  std::uint32_t record_;
};

}  // namespace distributed
}  // namespace fuse_flow
