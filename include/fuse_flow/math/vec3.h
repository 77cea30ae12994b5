#pragma once

#include <fuse_flow/math/host_device.h>

#include <cmath>

namespace fuse_flow {

/** \brief Three floats in registers: the vector type of the per-pixel maths, on the CPU and on the GPU.
 *  Trivial: Vec3{} is zero, Vec3 v; is not. */
struct Vec3 {
  ///@{
  /** \brief Metres, where it is a position. */
  float x;
  float y;
  float z;
  ///@}
};

/** \name Arithmetic */
///@{
FUSE_FLOW_HD Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
FUSE_FLOW_HD Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
FUSE_FLOW_HD Vec3 operator*(float s, const Vec3& a) { return {s * a.x, s * a.y, s * a.z}; }
FUSE_FLOW_HD float dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
FUSE_FLOW_HD Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
FUSE_FLOW_HD float squaredNorm(const Vec3& a) { return dot(a, a); }
FUSE_FLOW_HD bool isFinite(const Vec3& a) { return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z); }
///@}

/** \brief std::clamp, which device code cannot call. */
template <typename Value>
FUSE_FLOW_HD Value clampTo(Value v, Value low, Value high) {
  return v < low ? low : (high < v ? high : v);
}

/** \brief A rigid motion p ↦ R p + t, R row-major. */
struct alignas(16) RigidTransform {
  float r[9]{1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< R, orthonormal
  Vec3 t{};                               ///< metres
};

/** \brief R p. */
FUSE_FLOW_HD Vec3 rotate(const RigidTransform& T, const Vec3& p) {
  return {T.r[0] * p.x + T.r[1] * p.y + T.r[2] * p.z, T.r[3] * p.x + T.r[4] * p.y + T.r[5] * p.z,
          T.r[6] * p.x + T.r[7] * p.y + T.r[8] * p.z};
}
/** \brief R p + t. */
FUSE_FLOW_HD Vec3 operator*(const RigidTransform& T, const Vec3& p) { return rotate(T, p) + T.t; }

}  // namespace fuse_flow
