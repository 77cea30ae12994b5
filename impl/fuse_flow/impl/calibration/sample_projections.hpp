#pragma once

#include <fuse_flow/impl/host/wide_vectors.hpp>
#include <fuse_flow/math/calibration/correspondence.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief Where some samples of one view fall in others: the first step of findMatch(), which most go no farther than, in arrays and loops
 *  without branches, which compilers vectorise. One a thread, with the memory it keeps. */
class SampleProjections {
 public:
  /** \brief Every stride-th of the samples from begin to end. \param T camera → world */
  void assign(const RigidTransform& T, const std::vector<AlignmentSample>& samples, std::size_t begin, std::size_t end,
              std::size_t stride) {
    n_ = 0;
    const std::size_t most = (end - begin + stride - 1) / stride;
    if (X_.size() < most) {
      for (std::vector<float>* a : {&X_, &Y_, &Z_, &x_, &y_, &z_}) a->resize(most);
      for (std::vector<std::int32_t>* a : {&u_, &v_}) a->resize(most);
    }
    for (std::size_t s = begin; s < end; s += stride, ++n_) {
      const Vec3 x = T * samples[s].p;
      X_[n_] = x.x;
      Y_[n_] = x.y;
      Z_[n_] = x.z;
    }
  }

  std::size_t size() const { return n_; }

  /** \brief Projects them into a view, and sends for what is there. \param T world → its camera */
  void project(const RigidTransform& T, const BlockImage& image) {
    if (image.ideal) {
      inWideVectors([&] {
        projectAll(n_, T, image.intrinsics, image.reduction, image.width, image.height, X_.data(), Y_.data(), Z_.data(),
                   x_.data(), y_.data(), z_.data(), u_.data(), v_.data());
      });
    } else {
      for (std::size_t k = 0; k < n_; ++k) {
        const Vec3 q = T * Vec3{X_[k], Y_[k], Z_[k]};
        int u = 0, v = 0;
        u_[k] = image.locate(q, u, v) ? u : kOutside;
        v_[k] = v;
        x_[k] = q.x;
        y_[k] = q.y;
        z_[k] = q.z;
      }
    }
#if defined(__GNUC__)
    for (std::size_t k = 0; k < n_; ++k) {
      if (u_[k] == kOutside) continue;
      __builtin_prefetch(image.z + v_[k] * image.z_pitch + u_[k]);
      __builtin_prefetch(image.normals + image.index(u_[k], v_[k]));
    }
#endif
  }

  /** \brief Whether the k-th falls into the image; then match knows where. */
  bool inside(std::size_t k, Match& match) const {
    if (u_[k] == kOutside) return false;
    match.x = {X_[k], Y_[k], Z_[k]};
    match.q = {x_[k], y_[k], z_[k]};
    match.u = u_[k];
    match.v = v_[k];
    return true;
  }

 private:
  static constexpr std::int32_t kOutside = -1;

  static void projectAll(std::size_t n, RigidTransform T, Intrinsics K, int reduction, int width, int height,
                         const float* __restrict X, const float* __restrict Y, const float* __restrict Z,
                         float* __restrict x, float* __restrict y, float* __restrict z, std::int32_t* __restrict u,
                         std::int32_t* __restrict v) {
    const float per_block = 1.0f / static_cast<float>(reduction);
    const float columns = static_cast<float>(width), rows = static_cast<float>(height);
    for (std::size_t k = 0; k < n; ++k) {
      const Vec3 q = T * Vec3{X[k], Y[k], Z[k]};
      const float a = (K.fx * (q.x / q.z) + K.cx + 0.5f) * per_block;
      const float b = (K.fy * (q.y / q.z) + K.cy + 0.5f) * per_block;
      const bool inside = (q.z > 0) & (a >= 0) & (a < columns) & (b >= 0) & (b < rows);
      x[k] = q.x;
      y[k] = q.y;
      z[k] = q.z;
      u[k] = inside ? static_cast<std::int32_t>(inside ? a : 0.0f) : kOutside;
      v[k] = static_cast<std::int32_t>(inside ? b : 0.0f);
    }
  }

  std::size_t n_{0};
  std::vector<float> X_, Y_, Z_;  // world, metres
  std::vector<float> x_, y_, z_;  // the other camera's frame
  std::vector<std::int32_t> u_, v_;
};

}  // namespace host
}  // namespace fuse_flow
