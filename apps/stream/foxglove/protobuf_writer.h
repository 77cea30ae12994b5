#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

namespace fuse_flow::stream::foxglove {

/** \brief A message of Protocol Buffers, field after field. A handful of fields of five kinds is all that is needed here: no reason to depend on
 *  its library and its compiler. */
class ProtobufWriter {
 public:
  ProtobufWriter& whole(std::uint32_t field, std::uint64_t value) {
    key(field, 0);
    varint(value);
    return *this;
  }
  ProtobufWriter& fixed32(std::uint32_t field, std::uint32_t value) {
    key(field, 5);
    for (int shift = 0; shift < 32; shift += 8) bytes_ += static_cast<char>(value >> shift & 0xff);
    return *this;
  }
  ProtobufWriter& real(std::uint32_t field, double value) {
    key(field, 1);
    append(value);
    return *this;
  }
  /** \brief A repeated field, packed. */
  ProtobufWriter& reals(std::uint32_t field, const std::vector<double>& values) {
    beginBytes(field, 8 * values.size());
    for (const double value : values) append(value);
    return *this;
  }
  /** \brief Text, which must be UTF-8, or bytes. */
  ProtobufWriter& text(std::uint32_t field, std::string_view value) {
    beginBytes(field, value.size());
    bytes_ += value;
    return *this;
  }
  ProtobufWriter& message(std::uint32_t field, const ProtobufWriter& value) { return text(field, value.bytes_); }
  /** \brief google.protobuf.Timestamp. \param time nanoseconds since 1970 */
  ProtobufWriter& time(std::uint32_t field, std::uint64_t time) {
    constexpr std::uint64_t second = 1'000'000'000;
    return message(field, ProtobufWriter().whole(1, time / second).whole(2, time % second));
  }
  /** \brief So many bytes of this field follow, from elsewhere. */
  ProtobufWriter& beginBytes(std::uint32_t field, std::uint64_t size) {
    key(field, 2);
    varint(size);
    return *this;
  }

  const std::string& bytes() const { return bytes_; }

 private:
  void key(std::uint32_t field, std::uint32_t kind) { varint(field << 3 | kind); }
  void varint(std::uint64_t value) {
    for (; value >= 128; value >>= 7) bytes_ += static_cast<char>(value | 128);
    bytes_ += static_cast<char>(value);
  }
  void append(double value) {
    std::uint64_t bits;
    std::memcpy(&bits, &value, sizeof(bits));
    for (int shift = 0; shift < 64; shift += 8) bytes_ += static_cast<char>(bits >> shift & 0xff);
  }

  std::string bytes_;
};

}  // namespace fuse_flow::stream::foxglove
