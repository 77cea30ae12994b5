#pragma once

#include <fuse_flow/math/vec3.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <vector>

namespace fuse_flow {
namespace detail {

/** \brief Points bucketed by cells, to find those within a radius of a place. A cell is identified by a hash of its coordinates, which are
 *  whole numbers in double. So every finite position has a cell, at any distance from the origin. */
class PointIndex {
 public:
  /** \param cell side of a cell, metres; searches within up to about this are fast */
  PointIndex(std::vector<Vec3> points, float cell) : cell_(static_cast<double>(cell)) {
    std::size_t buckets = 64;
    while (buckets < points.size()) buckets *= 2;
    mask_ = buckets - 1;
    std::vector<std::uint64_t> keys;
    keys.reserve(points.size());
    begin_.assign(buckets + 1, 0);
    for (const Vec3& p : points) {
      keys.push_back(keyOf(cellOf(p)));
      ++begin_[(keys.back() & mask_) + 1];
    }
    for (std::size_t b = 0; b < buckets; ++b) begin_[b + 1] += begin_[b];
    std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
    entries_.resize(points.size());
    for (std::size_t k = 0; k < points.size(); ++k)
      entries_[next[keys[k] & mask_]++] = {keys[k], static_cast<std::uint32_t>(k), points[k]};
  }

  /** \brief Calls use(number, point) for all points within a radius; ends when it returns true, and then returns true. The cell of the
   *  place itself comes first. */
  template <typename Use>
  bool visit(const Vec3& place, float radius, const Use& use) const {
    const Cell middle = cellOf(place);
    const auto reach = static_cast<int>(std::ceil(static_cast<double>(radius) / cell_));
    if (visitCell(middle, place, radius, use)) return true;
    for (int z = -reach; z <= reach; ++z)
      for (int y = -reach; y <= reach; ++y)
        for (int x = -reach; x <= reach; ++x) {
          if (x == 0 && y == 0 && z == 0) continue;
          const Cell cell{middle.x + x, middle.y + y, middle.z + z};
          if (visited(cell, middle, x, y, z) || outOfReach(cell, place, radius)) continue;
          if (visitCell(cell, place, radius, use)) return true;
        }
    return false;
  }

  /** \brief A point and how far it is. */
  struct Neighbor {
    std::uint32_t number;
    float squared_distance;  ///< m²
  };

  /** \brief The nearest point within a radius; of equally near ones the one with the lowest number. */
  std::optional<Neighbor> nearest(const Vec3& place, float radius) const {
    std::optional<Neighbor> best;
    const auto use = [&](std::uint32_t number, const Vec3& point) {
      const float squared = squaredNorm(point - place);
      if (!best || squared < best->squared_distance || (squared == best->squared_distance && number < best->number))
        best = {number, squared};
      return false;
    };
    const Cell middle = cellOf(place);
    const auto reach = static_cast<int>(std::ceil(static_cast<double>(radius) / cell_));
    visitCell(middle, place, radius, use);
    // From the inside outwards, and no further than where nothing can be nearer.
    for (int shell = 1; shell <= reach; ++shell) {
      const float limit = best ? std::sqrt(best->squared_distance) : radius;
      if (static_cast<double>(limit) < (shell - 1) * cell_) break;
      for (int z = -shell; z <= shell; ++z)
        for (int y = -shell; y <= shell; ++y) {
          const bool face = std::abs(z) == shell || std::abs(y) == shell;
          for (int x = -shell; x <= shell; x += face ? 1 : 2 * shell) {
            const Cell cell{middle.x + x, middle.y + y, middle.z + z};
            const float now = best ? std::sqrt(best->squared_distance) : radius;
            if (!visited(cell, middle, x, y, z) && !outOfReach(cell, place, now)) visitCell(cell, place, radius, use);
          }
        }
    }
    return best;
  }

  bool anyWithin(const Vec3& place, float radius) const {
    return visit(place, radius, [](std::uint32_t, const Vec3&) { return true; });
  }

 private:
  struct Cell {
    double x, y, z;
  };
  struct Entry {
    std::uint64_t key;
    std::uint32_t number;
    Vec3 point;
  };

  Cell cellOf(const Vec3& p) const {
    return {std::floor(static_cast<double>(p.x) / cell_), std::floor(static_cast<double>(p.y) / cell_),
            std::floor(static_cast<double>(p.z) / cell_)};
  }

  /** \brief Beyond 2^53 cells from the origin a cell and the next have the same coordinate. */
  static bool visited(const Cell& cell, const Cell& middle, int x, int y, int z) {
    const auto same = [](double a, double b) { return !(a < b) && !(b < a); };
    return (x != 0 && same(cell.x, middle.x)) || (y != 0 && same(cell.y, middle.y)) ||
           (z != 0 && same(cell.z, middle.z));
  }

  bool outOfReach(const Cell& cell, const Vec3& place, float radius) const {
    const auto gap = [&](double number, float at) {
      const double low = number * cell_ - static_cast<double>(at),
                   high = static_cast<double>(at) - (number + 1) * cell_;
      return low > 0 ? low : (high > 0 ? high : 0.0);
    };
    const double x = gap(cell.x, place.x), y = gap(cell.y, place.y), z = gap(cell.z, place.z);
    const double r = static_cast<double>(radius);
    return x * x + y * y + z * z > 1.0001 * r * r;
  }

  static std::uint64_t keyOf(const Cell& cell) {
    std::uint64_t key = 0;
    for (const double number : {cell.x, cell.y, cell.z}) {
      const double positive = number + 0.0;  // −0 is 0
      std::uint64_t bits = 0;
      std::memcpy(&bits, &positive, sizeof bits);
      key = (key ^ bits) * 0x9e3779b97f4a7c15ull;
      key ^= key >> 29;
      key *= 0xbf58476d1ce4e5b9ull;
      key ^= key >> 32;
    }
    return key;
  }

  template <typename Use>
  bool visitCell(const Cell& cell, const Vec3& place, float radius, const Use& use) const {
    const std::uint64_t key = keyOf(cell);
    const std::size_t bucket = key & mask_;
    for (std::size_t k = begin_[bucket]; k < begin_[bucket + 1]; ++k) {
      const Entry& entry = entries_[k];
      if (entry.key == key && squaredNorm(entry.point - place) <= radius * radius && use(entry.number, entry.point))
        return true;
    }
    return false;
  }

  double cell_;
  std::size_t mask_{0};
  std::vector<std::size_t> begin_;
  std::vector<Entry> entries_;
};

}  // namespace detail
}  // namespace fuse_flow
