#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace fuse_flow::tables {

/** \brief Ranks from 1; equal values share the mean of theirs. */
inline std::vector<double> ranksOf(const std::vector<double>& values) {
  std::vector<double> ranks;
  for (const double value : values) {
    double below = 0, equal = 0;
    for (const double other : values) {
      below += other < value ? 1 : 0;
      equal += !(other < value) && !(value < other) ? 1 : 0;
    }
    ranks.push_back(below + 0.5 * (equal + 1));
  }
  return ranks;
}

/** \brief Spearman's rank correlation, −1 … 1, over the pairs in which both are known; NaN where there are fewer than three, or
 *  all values of one are equal. */
inline double rankCorrelation(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> x, y;
  for (std::size_t k = 0; k < a.size() && k < b.size(); ++k) {
    if (std::isnan(a[k]) || std::isnan(b[k])) continue;
    x.push_back(a[k]);
    y.push_back(b[k]);
  }
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  if (x.size() < 3) return unknown;
  x = ranksOf(x);
  y = ranksOf(y);
  const double mean = 0.5 * static_cast<double>(x.size() + 1);
  double xx = 0, yy = 0, xy = 0;
  for (std::size_t k = 0; k < x.size(); ++k) {
    xx += (x[k] - mean) * (x[k] - mean);
    yy += (y[k] - mean) * (y[k] - mean);
    xy += (x[k] - mean) * (y[k] - mean);
  }
  return xx > 0 && yy > 0 ? xy / std::sqrt(xx * yy) : unknown;
}

}  // namespace fuse_flow::tables
