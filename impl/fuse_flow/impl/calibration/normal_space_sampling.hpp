#pragma once

#include <fuse_flow/math/calibration/normal_space.h>

#include <algorithm>
#include <array>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief A number for each bin of directions. */
using NormalBinSizes = std::array<std::size_t, kNormalBins>;

/** \brief How many points of each bin are chosen, count at most in all: every bin gives as many, or all it has. */
inline NormalBinSizes evenShares(const NormalBinSizes& sizes, std::size_t count) {
  NormalBinSizes order;
  for (std::size_t b = 0; b < kNormalBins; ++b) order[b] = b;
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return sizes[a] != sizes[b] ? sizes[a] < sizes[b] : a < b; });
  NormalBinSizes shares;
  std::size_t chosen = 0;
  for (std::size_t k = 0; k < kNormalBins; ++k) {  // the smallest first: what they lack goes to the others
    shares[order[k]] = std::min((count - chosen) / (kNormalBins - k), sizes[order[k]]);
    chosen += shares[order[k]];
  }
  return shares;
}

/** \brief Chooses among points so that the directions of their normals come up as evenly as the points allow (Rusinkiewicz and
 *  Levoy 2001): a wall is many points, but tells of one direction only. */
class NormalSpaceSampling {
 public:
  /** \brief \param n unit normal in a frame that all views share  \param point any number */
  void add(const Vec3& n, std::uint32_t point) { bins_[normalBin(n)].push_back(point); }

  /** \brief At most count points, evenly spaced in each bin in the order of add(). */
  void choose(std::size_t count, std::vector<std::uint32_t>& chosen) const {
    NormalBinSizes sizes;
    for (std::size_t b = 0; b < kNormalBins; ++b) sizes[b] = bins_[b].size();
    const NormalBinSizes shares = evenShares(sizes, count);
    chosen.clear();
    for (std::size_t b = 0; b < kNormalBins; ++b)
      for (std::size_t i = 0; i < shares[b]; ++i) chosen.push_back(bins_[b][evenlySpaced(i, sizes[b], shares[b])]);
  }

 private:
  std::array<std::vector<std::uint32_t>, kNormalBins> bins_;
};

}  // namespace host
}  // namespace fuse_flow
