#include "calibration/opencv/square_edges.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace fuse_flow::io {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/** \brief Between pixels; nothing outside of the image. */
std::optional<double> brightness(const cv::Mat& grey, const Vector2d& at) {
  const double u = std::floor(at.x()), v = std::floor(at.y());
  if (!(u >= 0 && v >= 0 && u + 1 < grey.cols && v + 1 < grey.rows)) return std::nullopt;
  const double x = at.x() - u, y = at.y() - v;
  const unsigned char* upper = grey.ptr<unsigned char>(static_cast<int>(v)) + static_cast<int>(u);
  const unsigned char* lower = grey.ptr<unsigned char>(static_cast<int>(v) + 1) + static_cast<int>(u);
  return (1 - y) * ((1 - x) * upper[0] + x * upper[1]) + y * ((1 - x) * lower[0] + x * lower[1]);
}

/** \brief How far along a direction it turns from black to white: where it is half of both. */
std::optional<double> crossing(const cv::Mat& grey, const Vector2d& from, const Vector2d& outward, double reach) {
  constexpr double step = 0.25;
  const std::optional<double> black = brightness(grey, from - reach * outward);
  const std::optional<double> white = brightness(grey, from + reach * outward);
  if (!black || !white || *white - *black < 8) return std::nullopt;
  const double half = 0.5 * (*black + *white);
  double before = *black;
  for (double s = -reach + step; s <= reach; s += step) {
    const std::optional<double> here = brightness(grey, from + s * outward);
    if (!here) return std::nullopt;
    if (*here >= half) return s - step * (*here - half) / (*here - before);
    before = *here;
  }
  return std::nullopt;
}

/** \brief Distance of an edge from the line between two corners: c0 + c1 t + c2 t² with t from -1 to 1. The lens bends it. */
std::optional<Vector3d> edgeAlong(const cv::Mat& grey, const Vector2d& a, const Vector2d& b, const Vector2d& outward,
                                  double reach) {
  const int scans = std::clamp(static_cast<int>((b - a).norm()), 10, 100);
  std::vector<std::pair<double, double>> points;
  for (int k = 0; k < scans; ++k) {
    const double t = 0.85 * (2 * (k + 0.5) / scans - 1);  // the corners themselves are round
    if (const auto distance = crossing(grey, 0.5 * (a + b) + 0.5 * t * (b - a), outward, reach))
      points.emplace_back(t, *distance);
  }
  if (points.size() < static_cast<std::size_t>(scans) / 2) return std::nullopt;
  Vector3d fit = Vector3d::Zero();
  for (int pass = 0; pass < 3; ++pass) {
    Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
    Vector3d rhs = Vector3d::Zero();
    for (const auto& [t, distance] : points) {
      const Vector3d row(1, t, t * t);
      const double off = std::fabs(distance - fit.dot(row)), weight = pass == 0 || off < 0.3 ? 1 : 0.3 / off;
      A += weight * row * row.transpose();
      rhs += weight * distance * row;
    }
    fit = A.ldlt().solve(rhs);
  }
  return fit;
}

}  // namespace

bool fitEdges(const cv::Mat& grey, double border, DetectedMarker& marker) {
  std::array<Vector2d, 4> corners;
  for (std::size_t k = 0; k < 4; ++k)
    corners[k] = Vector2d(static_cast<double>(marker.corners[k].u), static_cast<double>(marker.corners[k].v));
  for (int pass = 0; pass < 3; ++pass) {
    const double share = pass < 2 ? 0.7 : 0.5;  // of the border, less where it is known better
    std::array<Vector2d, 4> outward;
    std::array<Vector3d, 4> edges;
    for (std::size_t k = 0; k < 4; ++k) {
      const Vector2d &a = corners[k], &b = corners[(k + 1) % 4];
      outward[k] = Vector2d(a.y() - b.y(), b.x() - a.x()).normalized();  // corners go round against the clock
      if (outward[k].dot(a - corners[(k + 2) % 4]) < 0) outward[k] = -outward[k];
      const double depth = std::fabs(outward[k].dot(a - corners[(k + 3) % 4]));  // of the square, across this edge
      const auto edge = edgeAlong(grey, a, b, outward[k], std::clamp(share * border * depth, 1.5, 4.0));
      if (!edge) return false;
      edges[k] = *edge;
    }
    std::array<Vector2d, 4> moved;
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t before = (k + 3) % 4;
      Eigen::Matrix2d N;
      N.row(0) = outward[before];
      N.row(1) = outward[k];
      const Vector2d d(edges[before].dot(Vector3d(1, 1, 1)), edges[k].dot(Vector3d(1, -1, 1)));
      moved[k] = corners[k] + N.inverse() * d;
      if (!((moved[k] - corners[k]).norm() < 5)) return false;
    }
    corners = moved;
  }
  for (std::size_t k = 0; k < 4; ++k)
    marker.corners[k] = {static_cast<float>(corners[k].x()), static_cast<float>(corners[k].y())};
  return true;
}

}  // namespace fuse_flow::io
