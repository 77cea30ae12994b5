#pragma once

#include <cstdint>

namespace fuse_flow {
namespace detail {

// Stamps come from drivers and may be any 64-bit number. They are computed modulo 2⁶⁴, because plain arithmetic would overflow.

/** \brief a − b, of times that are less than 2⁶³ µs apart. */
inline std::int64_t wrappingDifference(std::int64_t a, std::int64_t b) {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(a) - static_cast<std::uint64_t>(b));
}

inline std::int64_t wrappingSum(std::int64_t a, std::int64_t b) {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(a) + static_cast<std::uint64_t>(b));
}

/** \brief How far apart any two numbers are. */
inline std::uint64_t distance(std::int64_t a, std::int64_t b) {
  return a > b ? static_cast<std::uint64_t>(a) - static_cast<std::uint64_t>(b)
               : static_cast<std::uint64_t>(b) - static_cast<std::uint64_t>(a);
}

}  // namespace detail
}  // namespace fuse_flow
