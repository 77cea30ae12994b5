#include "recordings/calibrations/lens_models.h"

#include "recordings/calibrations/calibration.h"
#include "recordings/calibrations/lens_fit.h"
#include "recordings/files/cut_short.h"

#include <fuse_flow/recordings/error.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <functional>

namespace fuse_flow::io {
namespace {

/** \brief "Inverse Brown Conrady" and "inverse_brown_conrady" are the same. */
std::string plainName(const std::string& name) {
  std::string plain;
  for (const unsigned char c : name)
    if (std::isalnum(c)) plain += static_cast<char>(std::tolower(c));
  return plain;
}

struct Point {
  double x, y;
};
/** \brief From the distorted ray x/z, y/z of a pixel to the ray that it sees; NaN where it sees none. */
using Undistortion = std::function<Point(const Point&)>;

/** \brief θ_d = θ (1 + k1 θ² + k2 θ⁴ + k3 θ⁶ + k4 θ⁸) of the angle θ from the optical axis, solved for θ. */
Undistortion equidistant(const std::vector<double>& k) {
  return [k](const Point& p) -> Point {
    const double distorted = std::hypot(p.x, p.y);
    if (distorted < 1e-9) return p;
    double theta = distorted;
    for (int step = 0; step < 50; ++step) {
      const double t2 = theta * theta;
      const double f = theta * (1 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3])))) - distorted;
      const double slope = 1 + t2 * (3 * k[0] + t2 * (5 * k[1] + t2 * (7 * k[2] + t2 * 9 * k[3])));
      theta -= f / slope;
    }
    constexpr double widest = 1.4;  // rad, 80 degrees: beyond, a plane at depth 1 is no picture of it
    if (!(theta > 0 && theta < widest)) return {NAN, NAN};
    const double s = std::tan(theta) / distorted;
    return {p.x * s, p.y * s};
  };
}

/** \brief RealSense's polynomial of the distorted ray. */
Undistortion inverseBrownConrady(const std::vector<double>& k) {
  return [k](const Point& p) -> Point {
    const double r2 = p.x * p.x + p.y * p.y;
    const double f = 1 + k[0] * r2 + k[1] * r2 * r2 + k[4] * r2 * r2 * r2;
    return {p.x * f + 2 * k[2] * p.x * p.y + k[3] * (r2 + 2 * p.x * p.x),
            p.y * f + 2 * k[3] * p.x * p.y + k[2] * (r2 + 2 * p.y * p.y)};
  };
}

/** \brief By Newton's method with numeric derivatives. */
Undistortion inverseOf(const std::function<Point(const Point&)>& distortion) {
  return [distortion](const Point& p) -> Point {
    Point q = p;
    constexpr double h = 1e-5;
    for (int step = 0; step < 30; ++step) {
      const Point f = distortion(q), fx = distortion({q.x + h, q.y}), fy = distortion({q.x, q.y + h});
      const double a = (fx.x - f.x) / h, b = (fy.x - f.x) / h, c = (fx.y - f.y) / h, d = (fy.y - f.y) / h;
      const double det = a * d - b * c, ex = p.x - f.x, ey = p.y - f.y;
      q.x += (d * ex - b * ey) / det;
      q.y += (a * ey - c * ex) / det;
    }
    const Point f = distortion(q);
    return std::hypot(f.x - p.x, f.y - p.y) < 1e-7 ? q : Point{NAN, NAN};
  };
}

/** \brief RealSense's older one: tangential terms of what the radial ones gave. */
Undistortion modifiedBrownConrady(const std::vector<double>& k) {
  return inverseOf([k](const Point& p) -> Point {
    const double r2 = p.x * p.x + p.y * p.y;
    const double f = 1 + k[0] * r2 + k[1] * r2 * r2 + k[4] * r2 * r2 * r2;
    const double x = p.x * f, y = p.y * f;
    return {x + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x), y + 2 * k[3] * x * y + k[2] * (r2 + 2 * y * y)};
  });
}

/** \brief OpenCV's with all of its coefficients: behind k1 k2 p1 p2 k3 … k6 those of a thin prism, s1 … s4, and of a tilted sensor, its
 *  angles about x and y. */
Undistortion wholeOpencv(std::vector<double> k) {
  k.resize(14, 0.0);
  const double cx = std::cos(k[12]), sx = std::sin(k[12]), cy = std::cos(k[13]), sy = std::sin(k[13]);
  Eigen::Matrix3d R;
  R << cy, sy * sx, -sy * cx, 0, cx, sx, sy, -cy * sx, cy * cx;
  Eigen::Matrix3d tilt;
  tilt << R(2, 2), 0, -R(0, 2), 0, R(2, 2), -R(1, 2), 0, 0, 1;
  tilt = tilt * R;
  return inverseOf([k, tilt](const Point& p) -> Point {
    const double r2 = p.x * p.x + p.y * p.y, r4 = r2 * r2;
    const double s = (1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]))) / (1 + r2 * (k[5] + r2 * (k[6] + r2 * k[7])));
    const Eigen::Vector3d d(p.x * s + 2 * k[2] * p.x * p.y + k[3] * (r2 + 2 * p.x * p.x) + k[8] * r2 + k[9] * r4,
                            p.y * s + k[2] * (r2 + 2 * p.y * p.y) + 2 * k[3] * p.x * p.y + k[10] * r2 + k[11] * r4, 1);
    return {(tilt * d).hnormalized().x(), (tilt * d).hnormalized().y()};
  });
}

/** \brief r_d = atan(2 r tan(w/2)) / w, solved for r. */
Undistortion fTheta(const std::vector<double>& k) {
  return [w = k[0]](const Point& p) -> Point {
    const double distorted = std::hypot(p.x, p.y);
    if (distorted < 1e-9) return p;
    const double s = std::tan(distorted * w) / (2 * std::tan(w / 2)) / distorted;
    return s > 0 ? Point{p.x * s, p.y * s} : Point{NAN, NAN};
  };
}

Intrinsics fitted(const std::string& owner, const std::string& model, const Intrinsics& K,
                  const Undistortion& undistort, std::vector<std::string>& warnings) {
  constexpr int steps = 60;  // along a side
  std::vector<PixelRay> rays;
  for (int j = 0; j <= steps; ++j)
    for (int i = 0; i <= steps; ++i) {
      const double u = (K.width - 1.0) * i / steps, v = (K.height - 1.0) * j / steps;
      const Point ray = undistort({(u - K.cx) / K.fx, (v - K.cy) / K.fy});
      if (std::isfinite(ray.x) && std::isfinite(ray.y)) rays.push_back({u, v, ray.x, ray.y});
    }
  constexpr double nearest = 0.5;  // pixels
  const LensFit fit = rays.size() < 100 ? LensFit{{}, 0, 1e9} : fitLens(rays, K.width, K.height);
  if (!(fit.worst <= nearest))
    throw InputError(owner + ": its lens of the model " + model +
                     " is not like any Brown-Conrady lens within half a pixel; its images must be rectified");
  constexpr std::size_t all = (steps + 1) * (steps + 1);
  if (rays.size() < all)
    warnings.push_back(owner + ": " + std::to_string(100 * (all - rays.size()) / all) +
                       " % of its pixels see more than 80 degrees aside, or nothing, by its lens of the model " +
                       model + "; what they measure is placed wrongly, and must be masked out");
  if (fit.worst > 0.01) {
    char line[64];
    std::snprintf(line, sizeof line, "%.2f", fit.worst);
    warnings.push_back(owner + ": its lens of the model " + model + " is taken as the nearest Brown-Conrady lens, " +
                       line + " pixels off at most");
  }
  return fit.intrinsics;
}

bool isOneOf(const std::string& model, std::initializer_list<const char*> names) {
  return std::any_of(names.begin(), names.end(), [&](const char* name) { return model == name; });
}

}  // namespace

Intrinsics withDistortion(const std::string& owner, const Intrinsics& K, const std::string& model,
                          const std::vector<double>& k, std::vector<std::string>& warnings) {
  const auto zero = [](double x) { return x == 0; };
  const std::string name = plainName(model);
  const bool is_equidistant = isOneOf(name, {"equidistant", "fisheye", "kannalabrandt", "kannalabrandt4"});
  // Of whichever other kind, it distorts nothing; an equidistant lens is none that a pinhole is.
  if (!is_equidistant && std::all_of(k.begin(), k.end(), zero)) return K;
  const auto needs = [&](std::size_t count) {
    if (k.size() >= count && std::all_of(k.begin() + static_cast<std::ptrdiff_t>(count), k.end(), zero)) return;
    throw InputError(owner + ": has " + std::to_string(k.size()) + " distortion coefficients, must have " +
                     std::to_string(count) + " with the model " + cutShort(model));
  };
  const auto nearest = [&](const std::string& called, const Undistortion& undistort) {
    if (K.width <= 0 || K.height <= 0)
      throw InputError(owner + ": the size of its images must be given with the lens model " + called);
    return fitted(owner, called, K, undistort, warnings);
  };
  if (isOneOf(name, {"", "none", "pinhole", "plumbbob", "rationalpolynomial", "brownconrady", "radialtangential",
                     "radtan", "opencv"})) {
    if ((k.size() == 12 || k.size() == 14) && !std::all_of(k.begin() + 8, k.end(), zero))
      return nearest("OpenCV's with thin prism or tilt", wholeOpencv(k));
    Intrinsics distorted = K;
    distorted.distortion = distortionOf(owner, k);
    return distorted;
  }
  if (is_equidistant) {
    needs(4);
    return nearest("equidistant", equidistant(k));
  }
  if (name == "inversebrownconrady") {
    needs(5);
    return nearest("inverse Brown-Conrady", inverseBrownConrady(k));
  }
  if (name == "modifiedbrownconrady") {
    needs(5);
    return nearest("modified Brown-Conrady", modifiedBrownConrady(k));
  }
  if (name == "ftheta") {
    needs(1);
    return nearest("F-Theta", fTheta(k));
  }
  throw InputError(
      owner + ": the lens model is " + cutShort(model) +
      ", must be plumb_bob, rational_polynomial, equidistant, inverse_brown_conrady, modified_brown_conrady or "
      "ftheta; or undistort the images");
}

}  // namespace fuse_flow::io
