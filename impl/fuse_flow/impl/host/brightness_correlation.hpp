#pragma once

#include <algorithm>
#include <cmath>

namespace fuse_flow {
namespace host {

/** \brief Sums over what two views see of one place each, in grey levels. */
template <typename Scalar>
struct BrightnessCorrelation {
  Scalar count{0};
  Scalar first{0}, second{0};                           ///< sums of levels
  Scalar first_squared{0}, second_squared{0}, both{0};  ///< … and of products

  void add(Scalar a, Scalar b) {
    count += 1;
    first += a;
    second += b;
    first_squared += a * a;
    second_squared += b * b;
    both += a * b;
  }

  /** \brief How certain it is that both see the same: Fisher's z of their correlation, over its standard deviation 1/√n. That one
   *  is brighter, or has more contrast, does not count; neither do differences of less than a grey level. ≥ 0. */
  Scalar evidence() const {
    constexpr Scalar fewest = 30, noise = 1 /* grey level, squared */, most = Scalar(0.99);
    if (!(count >= fewest)) return 0;
    const Scalar covariance = both - first * second / count;
    if (!(covariance > 0)) return 0;
    const Scalar a = first_squared - first * first / count + noise * count,
                 b = second_squared - second * second / count + noise * count;
    return std::sqrt(count) * std::atanh(std::min(most, covariance / std::sqrt(a * b)));
  }
};

}  // namespace host
}  // namespace fuse_flow
