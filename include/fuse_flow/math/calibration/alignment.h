#pragma once

#include <fuse_flow/math/vec3.h>

namespace fuse_flow {

// Point-to-plane alignment of depth views. A point x of view i, beside the plane through d with normal n that view j measured
// there, leaves the residual r = n · (x − d). A twist ξ_i = (t, ω) of camera i about the origin, x ↦ x + t + ω × x, changes r
// by a · ξ_i with a = (n, x × n), and the same twist of camera j by −a · ξ_j, because d and n move along. So a pair of views
// adds one 6×6 matrix to the normal equations, +A on the two diagonal blocks and −A on the two others, as in the Laplacian of
// a graph. Lengths are in units of the scene's radius where they are levers.

/** \brief The upper triangle of a symmetric 6×6 matrix, row by row. */
constexpr int kTriangle6 = 21;

/** \brief Sums over the correspondences of one ordered pair of views; w is the weight of each. */
struct AlignmentSums {
  double A[kTriangle6];  ///< Σ w a aᵀ
  double g[6];           ///< Σ w r a
  double w;              ///< Σ w
  double wx[3];          ///< Σ w x
  double wxx[6];         ///< Σ w x xᵀ, upper triangle
  double wr;             ///< Σ w r
  double wrr;            ///< Σ w r²
  double count;          ///< of correspondences, independent of their weight
  double wa[6];          ///< Σ w a
  double wb[6];          ///< of colour: Σ w b, b as a, but of the gradient that the point's own image shows
  double shared[36];     ///< … and Σ w a bᵀ, row by row

  /** \brief The sums of two sets of correspondences. */
  FUSE_FLOW_HD AlignmentSums& operator+=(const AlignmentSums& o) {
    for (int k = 0; k < kTriangle6; ++k) A[k] += o.A[k];
    for (int k = 0; k < 6; ++k) g[k] += o.g[k];
    w += o.w;
    for (int k = 0; k < 3; ++k) wx[k] += o.wx[k];
    for (int k = 0; k < 6; ++k) wxx[k] += o.wxx[k];
    wr += o.wr;
    wrr += o.wrr;
    count += o.count;
    for (int k = 0; k < 6; ++k) wa[k] += o.wa[k];
    for (int k = 0; k < 6; ++k) wb[k] += o.wb[k];
    for (int k = 0; k < 36; ++k) shared[k] += o.shared[k];
    return *this;
  }
};

/** \brief Adds a correspondence. \param sums the sums to add to  \param x point, relative to the scene's centre, over its radius
 *  \param n unit normal, or gradient of the residual with respect to the point, world frame  \param r residual, metres
 *  \param weight ≥ 0 */
FUSE_FLOW_HD void addCorrespondence(AlignmentSums& sums, const Vec3& x, const Vec3& n, float r, float weight) {
  const Vec3 m = cross(x, n);
  const double a[6] = {n.x, n.y, n.z, m.x, m.y, m.z};
  const double w = weight;
  int k = 0;
  for (int row = 0; row < 6; ++row) {
    const double wa = w * a[row];
    for (int column = row; column < 6; ++column) sums.A[k++] += wa * a[column];
    sums.g[row] += wa * r;
    sums.wa[row] += wa;
  }
  const double p[3] = {x.x, x.y, x.z};
  k = 0;
  for (int row = 0; row < 3; ++row) {
    sums.wx[row] += w * p[row];
    for (int column = row; column < 3; ++column) sums.wxx[k++] += w * p[row] * p[column];
  }
  sums.w += w;
  sums.wr += w * r;
  sums.wrr += w * r * r;
  sums.count += 1;
}

/** \brief Adds a correspondence of colour. Noise of one image, and details that only one image resolves, contribute to A as much as details
 *  that both images show. In products of the gradients of both images, they average out.
 *  \param own the gradient n as the image shows it that the point is from */
FUSE_FLOW_HD void addCorrespondence(AlignmentSums& sums, const Vec3& x, const Vec3& n, const Vec3& own, float r,
                                    float weight) {
  addCorrespondence(sums, x, n, r, weight);
  const Vec3 m = cross(x, n), m_own = cross(x, own);
  const double a[6] = {n.x, n.y, n.z, m.x, m.y, m.z};
  const double b[6] = {own.x, own.y, own.z, m_own.x, m_own.y, m_own.z};
  const double w = weight;
  int k = 0;
  for (int row = 0; row < 6; ++row) {
    const double wa = w * a[row];
    sums.wb[row] += w * b[row];
    for (int column = 0; column < 6; ++column) sums.shared[k++] += wa * b[column];
  }
}

/** \brief Tukey's biweight: (1 − (r/c)²)² inside c, 0 outside. */
FUSE_FLOW_HD float tukeyWeight(float r, float c) {
  const float x = r / c;
  const float inside = 1.0f - x * x;
  return inside > 0 ? inside * inside : 0.0f;
}

}  // namespace fuse_flow
