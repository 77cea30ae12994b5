#pragma once

#include <fuse_flow/camera.h>

#include <pcl/exceptions.h>

#include <cmath>
#include <sstream>

namespace fuse_flow {
namespace detail {

template <typename... Parts>
[[noreturn]] void throwBadArgument(const Parts&... parts) {
  std::ostringstream message;
  (message << ... << parts);
  throw pcl::BadArgumentException(message.str());
}

/** \brief What a message calls a camera or its view. Put together only for a message: frames are checked without allocating. */
struct Owner {
  const char* before;
  const std::string& name;
  const char* after;
};

inline std::ostream& operator<<(std::ostream& out, const Owner& owner) {
  return out << owner.before << owner.name << owner.after;
}

inline void checkIntrinsics(const Owner& owner, const Intrinsics& K) {
  if (K.width <= 0 || K.height <= 0)
    throwBadArgument(owner, ": image size is ", K.width, "x", K.height, ", must be positive");
  if (!(std::isfinite(K.fx) && K.fx > 0)) throwBadArgument(owner, ": fx is ", K.fx, ", must be positive");
  if (!(std::isfinite(K.fy) && K.fy > 0)) throwBadArgument(owner, ": fy is ", K.fy, ", must be positive");
  if (!std::isfinite(K.cx)) throwBadArgument(owner, ": cx is ", K.cx, ", must be finite");
  if (!std::isfinite(K.cy)) throwBadArgument(owner, ": cy is ", K.cy, ", must be finite");
  const Distortion& d = K.distortion;
  for (const float k : {d.k1, d.k2, d.p1, d.p2, d.k3, d.k4, d.k5, d.k6})
    if (!std::isfinite(k)) throwBadArgument(owner, ": a distortion coefficient is ", k, ", must be finite");
}

inline void checkPose(const Owner& owner, const char* pose, const Eigen::Isometry3d& T) {
  if (!T.matrix().allFinite()) throwBadArgument(owner, ": ", pose, " holds a number that is not finite");
  const Eigen::Matrix3d R = T.linear();
  const double error = (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (error > 1e-3 || R.determinant() < 0)
    throwBadArgument(owner, ": ", pose, " is not rigid: R'R differs from the identity by ", error, ", det R is ",
                     R.determinant());
}

inline bool sameIntrinsics(const Intrinsics& a, const Intrinsics& b) {
  const Distortion& d = a.distortion;
  const Distortion& e = b.distortion;
  return a.width == b.width && a.height == b.height && a.fx == b.fx && a.fy == b.fy && a.cx == b.cx && a.cy == b.cy &&
         d.k1 == e.k1 && d.k2 == e.k2 && d.p1 == e.p1 && d.p2 == e.p2 && d.k3 == e.k3 && d.k4 == e.k4 && d.k5 == e.k5 &&
         d.k6 == e.k6;
}

inline void checkDepthCorrection(const Owner& owner, const DepthCorrection& correction) {
  if (correction.empty() && correction.rows == 0 && correction.relative.empty() && correction.per_metre.empty()) return;
  constexpr int most = 64;
  if (correction.columns < 2 || correction.rows < 2 || correction.columns > most || correction.rows > most)
    throwBadArgument(owner, ": depth_correction has ", correction.columns, "x", correction.rows,
                     " knots, must be 2x2 to ", most, "x", most);
  const std::size_t knots = static_cast<std::size_t>(correction.columns) * static_cast<std::size_t>(correction.rows);
  const auto check = [&](const char* name, const std::vector<float>& values) {
    if (values.size() != knots)
      throwBadArgument(owner, ": depth_correction.", name, " has ", values.size(), " numbers, must be ", knots);
    for (const float value : values)
      if (!(value >= -0.5f && value <= 0.5f))
        throwBadArgument(owner, ": depth_correction.", name, " has ", value, ", must be -0.5 to 0.5");
  };
  check("relative", correction.relative);
  check("per_metre", correction.per_metre);
}

inline void checkNoise(const Owner& owner, const NoiseModel& noise) {
  const auto check = [&](const char* name, float value) {
    if (!(value >= 0 && value <= 10)) throwBadArgument(owner, ": noise.", name, " is ", value, ", must be 0 to 10");
  };
  check("floor", noise.floor);
  check("linear", noise.linear);
  check("quadratic", noise.quadratic);
  if (!(noise.floor + noise.linear + noise.quadratic > 0))
    throwBadArgument(owner, ": noise is 0 at every depth; leave it out where it is not known");
}

inline void checkMultipath(const Owner& owner, const Multipath& multipath) {
  const float f = multipath.modulation_frequency;
  if (!(f == 0 || (f >= 1e6f && f <= 1e9f)))
    throwBadArgument(owner, ": multipath.modulation_frequency is ", f, " Hz, must be 0 or 1e6 to 1e9");
  if (!(multipath.reflectance > 0 && multipath.reflectance <= 1))
    throwBadArgument(owner, ": multipath.reflectance is ", multipath.reflectance, ", must be in (0, 1]");
}

}  // namespace detail

inline void checkCamera(const Camera& camera) {
  const detail::Owner owner{"fuse_flow::Camera '", camera.name, "'"};
  detail::checkIntrinsics(owner, camera.intrinsics);
  if (!(std::isfinite(camera.depth_scale) && camera.depth_scale > 0))
    detail::throwBadArgument(owner, ": depth_scale is ", camera.depth_scale, ", must be positive");
  detail::checkPose(owner, "T_world_camera", camera.T_world_camera);
  detail::checkDepthCorrection(owner, camera.depth_correction);
  detail::checkMultipath(owner, camera.multipath);
  if (camera.noise) detail::checkNoise(owner, *camera.noise);
  if (camera.color) {
    const detail::Owner color{"fuse_flow::Camera '", camera.name, "' color"};
    detail::checkIntrinsics(color, camera.color->intrinsics);
    detail::checkPose(color, "T_depth_color", camera.color->T_depth_color);
  }
}

inline RigidTransform toRigidTransform(const Eigen::Isometry3d& T) {
  RigidTransform result;
  for (int row = 0; row < 3; ++row)
    for (int col = 0; col < 3; ++col) result.r[3 * row + col] = static_cast<float>(T.linear()(row, col));
  const Eigen::Vector3f t = T.translation().cast<float>();
  result.t = {t.x(), t.y(), t.z()};
  return result;
}

namespace detail {

/** \brief Whether all of the calibration but the pose in the world is the same. */
inline bool sameInside(const Camera& a, const Camera& b) {
  if (!sameIntrinsics(a.intrinsics, b.intrinsics) || a.depth_scale != b.depth_scale ||
      a.depth_correction != b.depth_correction || a.multipath != b.multipath || a.noise != b.noise)
    return false;
  if (a.color.has_value() != b.color.has_value()) return false;
  return !a.color || (sameIntrinsics(a.color->intrinsics, b.color->intrinsics) &&
                      a.color->T_depth_color.matrix() == b.color->T_depth_color.matrix());
}

}  // namespace detail

inline bool sameCalibration(const Camera& a, const Camera& b) {
  return detail::sameInside(a, b) && a.T_world_camera.matrix() == b.T_world_camera.matrix();
}

}  // namespace fuse_flow
