#include "recordings/calibrations/lens_fit.h"

#include <Eigen/Dense>
#include <unsupported/Eigen/NonLinearOptimization>

#include <algorithm>
#include <cmath>

namespace fuse_flow::io {
namespace {

/** \brief Unknowns: fx, fy, cx, cy, then k1 k2 p1 p2 k3 k4 k5 k6. distort() of math/pinhole.h in double precision, which the derivatives
 *  need. */
struct Projection {
  Eigen::Matrix<double, 12, 1> p = Eigen::Matrix<double, 12, 1>::Zero();

  Eigen::Vector2d operator()(const PixelRay& ray) const {
    const double x = ray.x, y = ray.y, r2 = x * x + y * y;
    const double k1 = p[4], k2 = p[5], p1 = p[6], p2 = p[7], k3 = p[8], k4 = p[9], k5 = p[10], k6 = p[11];
    const double s = (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)));
    return {p[0] * (x * s + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + p[2],
            p[1] * (y * s + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + p[3]};
  }
};

/** \brief What Eigen's Levenberg-Marquardt asks for: the errors of all pixels, by the first unknowns; the others stay 0. */
struct Errors {
  using Scalar = double;
  using InputType = Eigen::VectorXd;
  using ValueType = Eigen::VectorXd;
  using JacobianType = Eigen::MatrixXd;
  enum { InputsAtCompileTime = Eigen::Dynamic, ValuesAtCompileTime = Eigen::Dynamic };

  const std::vector<PixelRay>& rays;
  int unknowns;

  int inputs() const { return unknowns; }
  int values() const { return static_cast<int>(2 * rays.size()); }
  int operator()(const Eigen::VectorXd& x, Eigen::VectorXd& errors) const {
    Projection projection;
    projection.p.head(unknowns) = x;
    for (std::size_t i = 0; i < rays.size(); ++i)
      errors.segment<2>(static_cast<Eigen::Index>(2 * i)) = projection(rays[i]) - Eigen::Vector2d(rays[i].u, rays[i].v);
    return 0;
  }
};

/** \brief Of pixel = f · ray + c, by least squares. */
Eigen::Vector2d fitLine(const std::vector<PixelRay>& rays, double PixelRay::*ray, double PixelRay::*pixel) {
  double n = 0, r = 0, p = 0, rr = 0, rp = 0;
  for (const PixelRay& one : rays) {
    n += 1;
    r += one.*ray;
    p += one.*pixel;
    rr += one.*ray * (one.*ray);
    rp += one.*ray * (one.*pixel);
  }
  const double f = (n * rp - r * p) / (n * rr - r * r);
  return {f, (p - f * r) / n};
}

/** \brief Of a lens as it is kept: rounded to single precision. */
LensFit measure(const Eigen::VectorXd& x, const std::vector<PixelRay>& rays, int width, int height) {
  Eigen::Matrix<float, 12, 1> k = Eigen::Matrix<float, 12, 1>::Zero();
  k.head(x.size()) = x.cast<float>();
  Intrinsics K;
  K.width = width;
  K.height = height;
  K.fx = k[0];
  K.fy = k[1];
  K.cx = k[2];
  K.cy = k[3];
  K.distortion = {k[4], k[5], k[6], k[7], k[8], k[9], k[10], k[11]};
  return measureLens(K, rays);
}

}  // namespace

LensFit measureLens(const Intrinsics& K, const std::vector<PixelRay>& rays) {
  const Distortion& d = K.distortion;
  Eigen::Matrix<float, 12, 1> k;
  k << K.fx, K.fy, K.cx, K.cy, d.k1, d.k2, d.p1, d.p2, d.k3, d.k4, d.k5, d.k6;
  Projection projection;
  projection.p = k.cast<double>();
  LensFit fit;
  fit.intrinsics = K;
  double sum = 0;
  for (const PixelRay& ray : rays) {
    const double squared = (projection(ray) - Eigen::Vector2d(ray.u, ray.v)).squaredNorm();
    sum += squared;
    fit.worst = std::max(fit.worst, std::sqrt(squared));
  }
  fit.rms = std::sqrt(sum / static_cast<double>(rays.size()));
  return fit;
}

LensFit fitLens(const std::vector<PixelRay>& rays, int width, int height) {
  const Eigen::Vector2d horizontal = fitLine(rays, &PixelRay::x, &PixelRay::u),
                        vertical = fitLine(rays, &PixelRay::y, &PixelRay::v);
  Eigen::VectorXd x(4);
  x << horizontal[0], vertical[0], horizontal[1], vertical[1];
  LensFit best = measure(x, rays, width, height);
  constexpr double exact = 0.01;  // pixels: nothing is left to explain
  constexpr double much = 0.7;    // of the error that a simpler lens leaves
  for (const int unknowns : {9, 12}) {
    if (!(best.worst > exact)) break;
    const Eigen::Index known = x.size();
    x.conservativeResize(unknowns);
    x.tail(unknowns - known).setZero();
    Eigen::NumericalDiff<Errors> errors(Errors{rays, unknowns});
    Eigen::LevenbergMarquardt<Eigen::NumericalDiff<Errors>> solver(errors);
    solver.parameters.maxfev = 40 * (unknowns + 1);
    solver.minimize(x);
    if (!x.allFinite()) break;
    const LensFit fit = measure(x, rays, width, height);
    if (fit.rms < much * best.rms) best = fit;
  }
  return best;
}

}  // namespace fuse_flow::io
