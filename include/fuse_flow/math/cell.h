#pragma once

#include <fuse_flow/math/vec3.h>

#include <cstdint>

namespace fuse_flow {

/** \brief Coarse cells are counted from the world's origin, not from the frame's minimum, so that a static surface
 *  falls into the same cells in every frame. 21 bits an axis: ±1,048,575 cells. */
struct CellIndex {
  ///@{
  /** \brief ⌊metres / cell_size⌋ along an axis of the world. */
  std::int32_t x{0}, y{0}, z{0};
  ///@}
};

/** \brief Farthest cell from the origin that fits a key, along each axis. */
constexpr std::int32_t kMaxCellCoordinate = (1 << 20) - 1;

/** \brief Whether all three coordinates, in cells, fit a key. False for NaN. */
FUSE_FLOW_HD bool fitsCellKey(const Vec3& cells) {
  const float limit = static_cast<float>(kMaxCellCoordinate - 1);
  return std::fabs(cells.x) < limit && std::fabs(cells.y) < limit && std::fabs(cells.z) < limit;
}

/** \brief ⌊v⌋ for |v| < 2³¹, by truncation: std::floor is a function call where SSE4.1 is not assumed. */
FUSE_FLOW_HD std::int32_t floorToInt(float v) {
  const std::int32_t truncated = static_cast<std::int32_t>(v);
  return truncated - (v < static_cast<float>(truncated) ? 1 : 0);
}

/** \brief The cell of a position in units of cells, for which fitsCellKey() holds. */
FUSE_FLOW_HD CellIndex cellIndex(const Vec3& cells) {
  return {floorToInt(cells.x), floorToInt(cells.y), floorToInt(cells.z)};
}

/** \brief 64-bit key of a coarse cell; distinct cells have distinct keys. */
FUSE_FLOW_HD std::uint64_t cellKey(const CellIndex& c) {
  const auto biased = [](std::int32_t v) { return static_cast<std::uint64_t>(v + (1 << 20)) & 0x1fffffu; };
  return biased(c.x) | biased(c.y) << 21 | biased(c.z) << 42;
}

/** \brief Inverse of cellKey(). */
FUSE_FLOW_HD CellIndex cellOfKey(std::uint64_t key) {
  const auto unbiased = [](std::uint64_t bits) { return static_cast<std::int32_t>(bits & 0x1fffffu) - (1 << 20); };
  return {unbiased(key), unbiased(key >> 21), unbiased(key >> 42)};
}

/** \brief Spreads keys of neighbouring cells over the table (Fibonacci hashing of the folded key). */
FUSE_FLOW_HD std::uint64_t hashCellKey(std::uint64_t key) {
  key ^= key >> 32;
  key *= 0x9e3779b97f4a7c15ull;
  return key ^ key >> 29;
}

/** \brief The corner of a coarse cell with the smallest coordinates, metres. */
FUSE_FLOW_HD Vec3 cellCorner(std::uint64_t key, float cell_size) {
  const CellIndex c = cellOfKey(key);
  return {static_cast<float>(c.x) * cell_size, static_cast<float>(c.y) * cell_size,
          static_cast<float>(c.z) * cell_size};
}

/** \brief Children of a coarse cell in a metre. */
FUSE_FLOW_HD float childrenPerMetre(int level, float cell_size) { return static_cast<float>(1 << level) / cell_size; }

/** \brief Which child of a coarse cell at a level a point falls into: x, y and z of level bits each. \param relative the
 *  point from the cell's corner, metres  \param to_child childrenPerMetre() */
FUSE_FLOW_HD std::uint32_t childPosition(const Vec3& relative, int level, float to_child) {
  const float last = static_cast<float>((1 << level) - 1);
  const int x = static_cast<int>(clampTo(to_child * relative.x, 0.0f, last));
  const int y = static_cast<int>(clampTo(to_child * relative.y, 0.0f, last));
  const int z = static_cast<int>(clampTo(to_child * relative.z, 0.0f, last));
  return static_cast<std::uint32_t>(x | y << level | z << 2 * level);
}

/** \brief Section 5 (1) d: the level L at which a coarse cell of count points is split into children of size/2^L. A
 *  surface fills about 4^L of the 8^L children; L is the smallest with at most points_per_cell in each of those. */
FUSE_FLOW_HD int refinementLevel(std::uint32_t count, float points_per_cell, int max_level) {
  int level = 0;
  float children = 1.0f;
  while (level<max_level&& static_cast<float>(count)> points_per_cell * children) {
    ++level;
    children *= 4.0f;
  }
  return level;
}

}  // namespace fuse_flow
