#pragma once

#include <Eigen/Geometry>

#include <cmath>

/** \file
 *  \brief Elementary functions made of operations that IEEE 754 fixes to the bit: plus, minus, times, divided by, square root.
 *  Those of the C library round otherwise from version to version, and on one processor otherwise than on the next, where they
 *  use a fused multiply-add that it has. Errors are under 1e-15 of the largest value on the way; angles in radians. */

namespace fuse_flow::simulation::portable {

namespace series {

/** \brief Taylor's series of sine and cosine, |x| up to π/4. */
inline double sine(double x) {
  const double s = x * x;
  double sum = 1;
  for (int n = 16; n >= 2; n -= 2) sum = 1 - s * (1.0 / (n * (n + 1))) * sum;
  return x * sum;
}
inline double cosine(double x) {
  const double s = x * x;
  double sum = 1;
  for (int n = 16; n >= 2; n -= 2) sum = 1 - s * (1.0 / (n * (n - 1))) * sum;
  return sum;
}

/** \brief Sine, or the cosine that is the sine a quarter of a turn on. */
inline double sineOfQuarters(double x, int quarters_more) {
  // π/2 in two parts, the first so short that its multiples are exact.
  constexpr double half_pi = 1.57079632673412561417, rest = 6.07710050650619224932e-11;
  const double quarters = std::floor(x * 0.63661977236758134 + 0.5);
  const double r = (x - quarters * half_pi) - quarters * rest;
  const double wrapped = quarters - 4 * std::floor(0.25 * quarters);
  const int quadrant = (static_cast<int>(wrapped) + quarters_more) & 3;
  const double value = (quadrant & 1) != 0 ? cosine(r) : sine(r);
  return (quadrant & 2) != 0 ? -value : value;
}

/** \brief Arc tangent of x in [0, 1]. */
inline double arcTangent(double x) {
  // The tangent of a quarter of the angle, at most 0.199.
  for (int k = 0; k < 2; ++k) x = x / (1 + std::sqrt(1 + x * x));
  const double s = x * x;
  double sum = 0;
  for (int n = 23; n >= 1; n -= 2) sum = 1.0 / n - s * sum;
  return 4 * x * sum;
}

constexpr double kPi = 3.14159265358979323846;

}  // namespace series

/** \brief |x| up to 1e6. */
inline double sin(double x) { return series::sineOfQuarters(x, 0); }
inline double cos(double x) { return series::sineOfQuarters(x, 1); }
inline double tan(double x) { return sin(x) / cos(x); }

inline double atan2(double y, double x) {
  const double a = std::fabs(x), b = std::fabs(y);
  if (!(a > 0) && !(b > 0)) return 0;
  const double acute = b <= a ? series::arcTangent(b / a) : 0.5 * series::kPi - series::arcTangent(a / b);
  const double angle = x < 0 ? series::kPi - acute : acute;
  return y < 0 ? -angle : angle;
}

inline double acos(double cosine) { return atan2(std::sqrt((1 - cosine) * (1 + cosine)), cosine); }

/** \brief 0 where the result would be no normal number. */
inline double exp(double x) {
  if (x < -700) return 0;
  // ln 2 in two parts, the first so short that its multiples are exact.
  constexpr double ln2 = 6.93147180369123816490e-01, rest = 1.90821492927058770002e-10;
  const double n = std::floor(x * 1.4426950408889634 + 0.5);
  const double r = (x - n * ln2) - n * rest;
  double sum = 1;
  for (int k = 14; k >= 1; --k) sum = 1 + r * (1.0 / k) * sum;
  return std::ldexp(sum, static_cast<int>(n));
}

inline double hypot(double x, double y) { return std::sqrt(x * x + y * y); }

inline float sin(float x) { return static_cast<float>(sin(static_cast<double>(x))); }
inline float cos(float x) { return static_cast<float>(cos(static_cast<double>(x))); }
inline float tan(float x) { return static_cast<float>(tan(static_cast<double>(x))); }
inline float acos(float x) { return static_cast<float>(acos(static_cast<double>(x))); }
inline float exp(float x) { return static_cast<float>(exp(static_cast<double>(x))); }
inline float atan2(float y, float x) {
  return static_cast<float>(atan2(static_cast<double>(y), static_cast<double>(x)));
}
inline float hypot(float x, float y) {
  return static_cast<float>(hypot(static_cast<double>(x), static_cast<double>(y)));
}

/** \brief A turn by an angle about a unit axis through the origin; as Eigen's AngleAxis, which asks the C library. */
template <typename Axis>
Eigen::Quaternion<typename Axis::Scalar> turn(typename Axis::Scalar angle, const Eigen::MatrixBase<Axis>& axis) {
  const typename Axis::Scalar half = angle / 2, c = cos(half), s = sin(half);
  const Eigen::Matrix<typename Axis::Scalar, 3, 1> v = s * axis;
  return {c, v.x(), v.y(), v.z()};
}

}  // namespace fuse_flow::simulation::portable
