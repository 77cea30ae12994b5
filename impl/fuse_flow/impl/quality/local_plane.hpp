#pragma once

#include <fuse_flow/impl/quality/point_index.hpp>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <vector>

namespace fuse_flow {
namespace detail {

/** \brief The plane that fits the points around a place best. */
struct LocalPlane {
  std::size_t points{0};
  Vec3 centroid{};
  Vec3 normal{};        ///< unit, of either sign
  double deviation{0};  ///< RMS distance of the points to it, metres
  static constexpr std::size_t kFewest = 6;
  explicit operator bool() const { return points >= kFewest; }
};

inline LocalPlane localPlane(const PointIndex& index, const Vec3& place, float radius) {
  LocalPlane plane;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
  index.visit(place, radius, [&](std::uint32_t, const Vec3& p) {
    const Vec3 by = p - place;
    const Eigen::Vector3d d(static_cast<double>(by.x), static_cast<double>(by.y), static_cast<double>(by.z));
    sum += d;
    products += d * d.transpose();
    ++plane.points;
    return false;
  });
  if (!plane) return plane;
  const auto n = static_cast<double>(plane.points);
  const Eigen::Vector3d mean = sum / n;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(products / n - mean * mean.transpose());
  const Eigen::Vector3d normal = axes.eigenvectors().col(0);
  plane.centroid =
      place + Vec3{static_cast<float>(mean.x()), static_cast<float>(mean.y()), static_cast<float>(mean.z())};
  plane.normal = {static_cast<float>(normal.x()), static_cast<float>(normal.y()), static_cast<float>(normal.z())};
  plane.deviation = std::sqrt(std::max(axes.eigenvalues()[0], 0.0));
  return plane;
}

/** \brief Heights cut in two where that explains most of their variance. */
struct TwoSheets {
  double separation{0};  ///< of the two means
  double deviation{0};   ///< within them
  double smaller{0};     ///< share of the points in the smaller one

  /** \brief Ashman's D for equal deviations is separation / deviation. */
  bool apart(double min_separation, double max_separation) const {
    constexpr double least_share = 0.2, ashman = 4;
    return smaller >= least_share && separation >= min_separation && separation <= max_separation &&
           separation >= ashman * deviation;
  }
};

inline TwoSheets cutInTwo(std::vector<double>& heights) {
  std::sort(heights.begin(), heights.end());
  double sum = 0, squares = 0;
  for (const double h : heights) sum += h, squares += h * h;
  const auto n = static_cast<double>(heights.size());
  double best = -1, left = 0;
  TwoSheets sheets;
  for (std::size_t k = 1; k < heights.size(); ++k) {
    left += heights[k - 1];
    const auto a = static_cast<double>(k), b = n - a;
    const double gap = (sum - left) / b - left / a, between = a * b / (n * n) * gap * gap;
    if (between <= best) continue;
    best = between;
    sheets.separation = gap;
    sheets.smaller = std::min(a, b) / n;
  }
  const double mean = sum / n;
  sheets.deviation = std::sqrt(std::max(squares / n - mean * mean - best, 0.0));
  return sheets;
}

}  // namespace detail
}  // namespace fuse_flow
