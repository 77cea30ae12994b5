#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace fuse_flow_fuzz {

/** \brief Choices that an input makes, byte by byte; 0 at its end. */
class Choices {
 public:
  explicit Choices(std::string_view input) : input_(input) {}

  bool left() const { return at_ < input_.size(); }
  std::uint8_t byte() { return left() ? static_cast<std::uint8_t>(input_[at_++]) : std::uint8_t{0}; }
  /** \brief 0 … n − 1. */
  std::size_t below(std::size_t n) {
    std::size_t value = byte();
    if (n > 256) value = value << 8 | byte();
    return value % n;
  }
  bool oneIn(std::size_t n) { return below(n) == n - 1; }
  std::uint64_t number() {
    std::uint64_t value = 0;
    for (int k = 0; k < 8; ++k) value = value << 8 | byte();
    return value;
  }

 private:
  std::string_view input_;
  std::size_t at_{0};
};

}  // namespace fuse_flow_fuzz
