#pragma once

#include <fuse_flow/math/vec3.h>

#include <limits>

namespace fuse_flow {

/** \brief Brown–Conrady lens with the rational radial term: with r² = x² + y²,
 *  s = (1 + k1 r² + k2 r⁴ + k3 r⁶) / (1 + k4 r² + k5 r⁴ + k6 r⁶),
 *  x_d = x s + 2 p1 x y + p2 (r² + 2 x²), y_d = y s + p1 (r² + 2 y²) + 2 p2 x y.
 *  All zero: an ideal lens. The order k1, k2, p1, p2, k3 … k6 is the one calibration tools write. */
struct Distortion {
  ///@{
  /** \brief Without unit. */
  float k1{0}, k2{0}, p1{0}, p2{0}, k3{0}, k4{0}, k5{0}, k6{0};
  ///@}
};

/** \brief Whether the lens is a pinhole. */
FUSE_FLOW_HD bool isIdeal(const Distortion& d) {
  return d.k1 == 0 && d.k2 == 0 && d.p1 == 0 && d.p2 == 0 && d.k3 == 0 && d.k4 == 0 && d.k5 == 0 && d.k6 == 0;
}

/** \brief Image size and intrinsic matrix K, pixels; pixel centres lie at integer coordinates. */
struct Intrinsics {
  int width{0};           ///< pixels in a row
  int height{0};          ///< rows
  float fx{0};            ///< focal length along rows, pixels; > 0
  float fy{0};            ///< focal length along columns, pixels; > 0
  float cx{0};            ///< principal point, pixels from the centre of the first column
  float cy{0};            ///< principal point, pixels from the centre of the first row
  Distortion distortion;  ///< of the lens
};

/** \brief A position in an image, pixels. */
struct Pixel {
  float u{0};  ///< to the right
  float v{0};  ///< down
};

/** \brief A ray through the optical centre: x/z and y/z of every point on it. */
struct Ray {
  float x{0};  ///< x/z, to the right
  float y{0};  ///< y/z, down
};

/** \brief Converts an ideal ray to the distorted ray. */
FUSE_FLOW_HD Ray distort(const Distortion& d, const Ray& p) {
  const float r2 = p.x * p.x + p.y * p.y;
  const float s = (1 + r2 * (d.k1 + r2 * (d.k2 + r2 * d.k3))) / (1 + r2 * (d.k4 + r2 * (d.k5 + r2 * d.k6)));
  return {p.x * s + 2 * d.p1 * p.x * p.y + d.p2 * (r2 + 2 * p.x * p.x),
          p.y * s + d.p1 * (r2 + 2 * p.y * p.y) + 2 * d.p2 * p.x * p.y};
}

/** \brief Inverse of distort() by Newton's method with a numeric Jacobian: quadratic convergence, where the usual
 *  fixed-point iteration creeps or diverges near the corners of wide lenses. */
FUSE_FLOW_HD Ray undistort(const Distortion& d, const Ray& distorted) {
  Ray p = distorted;
  constexpr float h = 1e-3f;
  for (int iteration = 0; iteration < 12; ++iteration) {
    const Ray f = distort(d, p);
    const float ex = distorted.x - f.x;
    const float ey = distorted.y - f.y;
    if (ex * ex + ey * ey < 1e-14f) break;
    const Ray xp = distort(d, {p.x + h, p.y});
    const Ray xm = distort(d, {p.x - h, p.y});
    const Ray yp = distort(d, {p.x, p.y + h});
    const Ray ym = distort(d, {p.x, p.y - h});
    const float a = (xp.x - xm.x) / (2 * h), b = (yp.x - ym.x) / (2 * h);
    const float c = (xp.y - xm.y) / (2 * h), e = (yp.y - ym.y) / (2 * h);
    const float determinant = a * e - b * c;
    if (!(determinant > 1e-6f)) break;  // the lens model folds over here; keep the best ray so far: see reaches()
    p.x += (e * ex - b * ey) / determinant;
    p.y += (a * ey - c * ex) / determinant;
  }
  return p;
}

/** \brief π of eq. 4: a point in the camera frame, z > 0, to its pixel. */
FUSE_FLOW_HD Pixel project(const Intrinsics& K, const Vec3& p_C) {
  Ray ray{p_C.x / p_C.z, p_C.y / p_C.z};
  if (!isIdeal(K.distortion)) ray = distort(K.distortion, ray);
  return {K.fx * ray.x + K.cx, K.fy * ray.y + K.cy};
}

/** \brief K and T̂ of an ideal lens in one 3×4 matrix: u = m₀·p / m₂·p, v = m₁·p / m₂·p, z = m₂·p for p in the world
 *  frame. */
struct ProjectionMatrix {
  alignas(16) float m[12];  ///< row-major; aligned: a GPU loads a row at once
};

/** \brief The matrix of an ideal lens; the distortion of K is left out. */
FUSE_FLOW_HD ProjectionMatrix projectionMatrix(const Intrinsics& K, const RigidTransform& T_camera_world) {
  const float* r = T_camera_world.r;
  const Vec3& t = T_camera_world.t;
  ProjectionMatrix P;
  for (int k = 0; k < 3; ++k) {
    P.m[k] = K.fx * r[k] + K.cx * r[6 + k];
    P.m[4 + k] = K.fy * r[3 + k] + K.cy * r[6 + k];
    P.m[8 + k] = r[6 + k];
  }
  P.m[3] = K.fx * t.x + K.cx * t.z;
  P.m[7] = K.fy * t.y + K.cy * t.z;
  P.m[11] = t.z;
  return P;
}

/** \brief (u z, v z, z) of a point in the world frame. */
FUSE_FLOW_HD Vec3 operator*(const ProjectionMatrix& P, const Vec3& p) {
  const float* m = P.m;
  return {m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3], m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7],
          m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11]};
}

/** \brief The ray through a pixel: π⁻¹ of eq. 5 and 8 at depth 1. */
FUSE_FLOW_HD Ray unproject(const Intrinsics& K, const Pixel& pixel) {
  const Ray ray{(pixel.u - K.cx) / K.fx, (pixel.v - K.cy) / K.fy};
  return isIdeal(K.distortion) ? ray : undistort(K.distortion, ray);
}

/** \brief Whether the ray that unproject() gave ends at its pixel, to a tenth of one. Where the lens model folds over, no ray does. */
FUSE_FLOW_HD bool reaches(const Intrinsics& K, const Ray& ray, const Pixel& pixel) {
  if (isIdeal(K.distortion)) return true;
  const Pixel end = project(K, {ray.x, ray.y, 1.0f});
  const float du = end.u - pixel.u, dv = end.v - pixel.v;
  return du * du + dv * dv < 0.01f;
}

/** \brief Where a lens model folds over: up to this length of (x/z, y/z), rays further out end further out. Infinite if that is so up to 87°. Of
 *  the radial coefficients; to a per cent. */
inline float foldRadius(const Distortion& distortion) {
  Distortion radial = distortion;
  radial.p1 = radial.p2 = 0;
  float before = 0, last = 0;
  for (float r = 0.01f; r < 20; r *= 1.01f) {
    const float end = distort(radial, {r, 0}).x;
    if (!(end > before)) return last;
    before = end;
    last = r;
  }
  return std::numeric_limits<float>::infinity();
}

/** \brief π⁻¹ of eq. 5 and 8: the point at depth z (metres, along the optical axis) on a ray. */
FUSE_FLOW_HD Vec3 pointOnRay(const Ray& ray, float z) { return {ray.x * z, ray.y * z, z}; }

}  // namespace fuse_flow
