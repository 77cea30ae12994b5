#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief Which children of a coarse cell have something, a bit each: rows along x, with empty ones around them. */
class ChildBits {
 public:
  /** \brief Begins with a cell of 2^level children along an axis, all of them empty. */
  void clear(int level) {
    level_ = level;
    const int side = (1 << level) + 2;
    rows_.assign(static_cast<std::size_t>(side * side), 0);
  }

  std::size_t capacity() const { return rows_.capacity(); }
  void reserve(std::size_t rows) { rows_.reserve(rows); }

  /** \param position childPosition() */
  void set(std::uint32_t position) { rows_[row(position)] |= std::uint64_t{2} << x(position); }

  /** \brief Whether a child or one of the 26 around it has something. */
  bool anyAround(std::uint32_t position) const {
    const std::size_t side = (std::size_t{1} << level_) + 2;
    const std::uint64_t* first = rows_.data() + row(position) - side - 1;
    std::uint64_t any = 0;
    for (std::size_t z = 0; z < 3; ++z)
      for (std::size_t y = 0; y < 3; ++y) any |= first[z * side + y];
    return (any >> x(position) & 7) != 0;
  }

 private:
  std::uint32_t x(std::uint32_t position) const { return position & ((1u << level_) - 1); }
  std::size_t row(std::uint32_t position) const {
    const std::size_t y = position >> level_ & ((1u << level_) - 1), z = position >> 2 * level_;
    return (z + 1) * ((std::size_t{1} << level_) + 2) + y + 1;
  }

  int level_{0};
  std::vector<std::uint64_t> rows_;
};

}  // namespace host
}  // namespace fuse_flow
