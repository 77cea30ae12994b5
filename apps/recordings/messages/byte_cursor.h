#pragma once

#include "recordings/streams/frame_sets.h"

#include <fuse_flow/recordings/error.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

namespace fuse_flow::io {

/** \brief Reads little-endian numbers one after the other. Every function throws InputError, beginning with the file's name, where the bytes end before. */
class ByteCursor {
 public:
  ByteCursor(const std::string& path, std::string_view bytes) : path_(path), bytes_(bytes) {}
  ByteCursor(const std::string& path, std::string&& bytes) = delete;  // they must stay

  std::uint8_t u8() { return number<std::uint8_t>(); }
  std::uint16_t u16() { return number<std::uint16_t>(); }
  std::uint32_t u32() { return number<std::uint32_t>(); }
  std::uint64_t u64() { return number<std::uint64_t>(); }
  /** \brief Nanoseconds of 64 bits, kLatestTime at most. */
  Nanoseconds time() { return static_cast<Nanoseconds>(std::min(u64(), static_cast<std::uint64_t>(kLatestTime))); }
  /** \brief Behind its length of 32 bits. */
  std::string text() { return std::string(take(u32())); }
  std::size_t position() const { return at_; }

 private:
  std::string_view take(std::size_t count) {
    if (count > bytes_.size() - at_) throw InputError(path_ + ": is damaged: a record is too short");
    at_ += count;
    return bytes_.substr(at_ - count, count);
  }
  template <typename Number>
  Number number() {
    Number value;
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
    return value;
  }

  const std::string& path_;
  std::string_view bytes_;
  std::size_t at_{0};
};

}  // namespace fuse_flow::io
