#include "recordings/messages/camera_lens.h"

#include "recordings/calibration.h"
#include "recordings/files/cut_short.h"
#include "recordings/lens_fit.h"

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
  if (fit.worst > 0.01) {
    char line[64];
    std::snprintf(line, sizeof line, "%.2f", fit.worst);
    warnings.push_back(owner + ": its lens of the model " + model + " is taken as the nearest Brown-Conrady lens, " +
                       line + " pixels off at most");
  }
  return fit.intrinsics;
}

}  // namespace

Intrinsics lensOf(const std::string& owner, const CameraInfoMessage& info, bool rectified,
                  std::vector<std::string>& warnings) {
  constexpr std::uint32_t widest = 65535;
  if (info.width == 0 || info.height == 0 || info.width > widest || info.height > widest)
    throw InputError(owner + ": is of " + std::to_string(info.width) + "x" + std::to_string(info.height) +
                     " pixels; the camera was not calibrated");
  const bool by_projection = rectified && info.P[0] > 0;
  Intrinsics K = by_projection ? intrinsicsOf(owner, {info.P[0], info.P[1], info.P[2], info.P[4], info.P[5], info.P[6],
                                                      info.P[8], info.P[9], info.P[10]})
                               : intrinsicsOf(owner, std::vector<double>(info.K, info.K + 9));
  // ROS's calibration is of the whole sensor; the image may be a part of it, and coarser.
  const auto binning = [](std::uint32_t n) { return n > 1 ? static_cast<float>(n) : 1.0f; };
  const float bx = binning(info.binning_x), by = binning(info.binning_y);
  K.fx /= bx;
  K.fy /= by;
  K.cx = (K.cx - static_cast<float>(info.roi_x) + 0.5f) / bx - 0.5f;
  K.cy = (K.cy - static_cast<float>(info.roi_y) + 0.5f) / by - 0.5f;
  K.width = static_cast<int>((info.roi_width > 0 ? info.roi_width : info.width) / static_cast<std::uint32_t>(bx));
  K.height = static_cast<int>((info.roi_height > 0 ? info.roi_height : info.height) / static_cast<std::uint32_t>(by));
  const bool ideal = std::all_of(info.D.begin(), info.D.end(), [](double k) { return k == 0; });
  if (by_projection || rectified || ideal) return K;
  const std::string model = plainName(info.distortion_model);
  const auto needs = [&](std::size_t count) {
    if (info.D.size() >= count) return;
    throw InputError(owner + ": has " + std::to_string(info.D.size()) + " distortion coefficients, must have " +
                     std::to_string(count) + " with the model " + cutShort(info.distortion_model));
  };
  if (model.empty() || model == "plumbbob" || model == "rationalpolynomial" || model == "brownconrady") {
    K.distortion = distortionOf(owner, info.D);
    return K;
  }
  if (model == "equidistant" || model == "fisheye" || model == "kannalabrandt4") {
    needs(4);
    return fitted(owner, "equidistant", K, equidistant(info.D), warnings);
  }
  if (model == "inversebrownconrady") {
    needs(5);
    return fitted(owner, "inverse Brown-Conrady", K, inverseBrownConrady(info.D), warnings);
  }
  if (model == "modifiedbrownconrady") {
    needs(5);
    return fitted(owner, "modified Brown-Conrady", K, modifiedBrownConrady(info.D), warnings);
  }
  if (model == "ftheta") {
    needs(1);
    return fitted(owner, "F-Theta", K, fTheta(info.D), warnings);
  }
  throw InputError(owner + ": distortion_model is '" + cutShort(info.distortion_model) +
                   "', must be plumb_bob, rational_polynomial, equidistant, or one of RealSense's");
}

}  // namespace fuse_flow::io
