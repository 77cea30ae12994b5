#pragma once

#include "stream/codec/morton.h"

#include <cmath>
#include <cstdint>

namespace fuse_flow::stream {

constexpr double kOriginAlignment = 64;  ///< steps: the origin moves rarely from frame to frame
constexpr double kMostSteps = 1 << kCoordinateBits;

/** \brief Where the lattice begins along an axis, in steps: a multiple of the alignment, so that a point has the same error in each frame.
 *  \param least coordinate of all points */
inline double originInSteps(float least, double step) {
  return std::floor(static_cast<double>(least) / step / kOriginAlignment) * kOriginAlignment + 0.0;  // no -0
}

/** \brief Whether a lattice that begins at the least coordinate has room for the greatest. */
inline bool fitsLattice(float least, float greatest, double step) {
  return static_cast<double>(greatest) - static_cast<double>(least) < (kMostSteps - 2 * kOriginAlignment) * step;
}

/** \brief The nearest point of the lattice; false: it is outside, or nowhere. \param p x, y, z in metres  \param first the origin in steps */
FUSE_FLOW_HD bool toLattice(const float* p, double per_metre, const Few<double, 3>& first, Lattice& lattice) {
  bool inside = true;
  for (std::size_t k = 0; k < 3; ++k) {
    const double steps = static_cast<double>(p[k]) * per_metre - first[k] + 0.5;
    inside = inside && steps >= 0 && steps < kMostSteps;  // false for NaN
    lattice[k] = inside ? static_cast<std::uint32_t>(steps) : 0;
  }
  return inside;
}

}  // namespace fuse_flow::stream
