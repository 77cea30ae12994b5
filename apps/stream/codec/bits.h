#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace fuse_flow::stream {

/** \brief Numbers of any number of bits, one after the other, the lowest bit of each byte first. */
class BitWriter {
 public:
  /** \param to has room for all that is put, and 8 bytes more */
  explicit BitWriter(std::uint8_t* to) : to_(to) {}

  /** \param value below 2^bits  \param bits 0 to 56 */
  void put(std::uint64_t value, int bits) {
    held_ |= value << count_;
    count_ += bits;
    std::memcpy(to_, &held_, 8);  // little-endian, as all machines that CUDA and PCL run on
    to_ += count_ >> 3;
    held_ >>= count_ & ~7;
    count_ &= 7;
  }
  /** \param bits 0 to 64 */
  void putLong(std::uint64_t value, int bits) {
    if (bits > 32) {
      put(value & 0xffffffffu, 32);
      put(value >> 32, bits - 32);
    } else {
      put(value, bits);
    }
  }
  /** \brief Where the next byte would go. */
  std::uint8_t* end() {
    if (count_ > 0) *to_++ = static_cast<std::uint8_t>(held_);
    held_ = 0;
    count_ = 0;
    return to_;
  }

 private:
  std::uint8_t* to_;
  std::uint64_t held_{0};
  int count_{0};
};

/** \brief Reads them. What is read after the end is 0, and overrun() is true from then on. */
class BitReader {
 public:
  BitReader(const std::uint8_t* data, std::size_t size) : data_(data), bits_(8 * size), size_(size) {}

  /** \param bits 0 to 56 */
  std::uint64_t get(int bits) {
    std::uint64_t word = 0;
    const std::size_t byte = position_ >> 3;
    if (byte + 8 <= size_) {
      std::memcpy(&word, data_ + byte, 8);
    } else if (byte < size_) {
      std::memcpy(&word, data_ + byte, size_ - byte);
    }
    word >>= position_ & 7;
    position_ += static_cast<std::size_t>(bits);
    return word & ((std::uint64_t{1} << bits) - 1);
  }
  /** \param bits 0 to 64 */
  std::uint64_t getLong(int bits) {
    if (bits <= 32) return get(bits);
    const std::uint64_t low = get(32);
    return low | get(bits - 32) << 32;
  }
  bool overrun() const { return position_ > bits_; }
  /** \brief Bytes of which nothing was read. */
  std::size_t unread() const { return overrun() ? 0 : (bits_ - position_) / 8; }

 private:
  const std::uint8_t* data_;
  std::size_t bits_;
  std::size_t size_;
  std::size_t position_{0};  ///< in bits
};

}  // namespace fuse_flow::stream
