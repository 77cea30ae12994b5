#pragma once

#include <algorithm>
#include <cmath>

namespace fuse_flow {
namespace host {

/** \brief Sums over what two views see of one place each, in grey levels. */
struct BrightnessCorrelation {
  double count{0};
  double first{0}, second{0};                           ///< sums of grey levels
  double first_squared{0}, second_squared{0}, both{0};  ///< … and of their products

  void add(double a, double b) {
    count += 1;
    first += a;
    second += b;
    first_squared += a * a;
    second_squared += b * b;
    both += a * b;
  }

  /** \brief How certain it is that both see the same: Fisher's z of their correlation r, artanh(r), over its standard deviation 1/√n.
   *  That one is brighter, or has more contrast, does not count; neither do differences of less than a grey level, whose
   *  variance is added to both. r counts as 0.99 at most. 0 for fewer than 30 places; ≥ 0. */
  double evidence() const {
    constexpr double fewest = 30, noise = 1 /* variance, grey levels² */, most = 0.99;
    if (!(count >= fewest)) return 0;
    const double covariance = both - first * second / count;
    if (!(covariance > 0)) return 0;
    const double a = first_squared - first * first / count + noise * count;
    const double b = second_squared - second * second / count + noise * count;
    return std::sqrt(count) * std::atanh(std::min(most, covariance / std::sqrt(a * b)));
  }
};

}  // namespace host
}  // namespace fuse_flow
