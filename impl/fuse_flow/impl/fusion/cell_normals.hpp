#pragma once

#include <fuse_flow/impl/host/wide_vectors.hpp>
#include <fuse_flow/impl/sensors/depth_map.hpp>
#include <fuse_flow/impl/sensors/depth_surface.hpp>
#include <fuse_flow/impl/sensors/rig_geometry.hpp>
#include <fuse_flow/math/view.h>

#include <cstddef>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief Where the surface faces at some points of one coarse cell: surfaceDirection() of each, world frame. First the depths
 *  around them are read, then all normals are computed, in arrays and a loop without branches, which compilers vectorise. */
class CellNormals {
 public:
  void clear() { n_ = 0; }
  std::size_t size() const { return n_; }
  std::size_t capacity() const { return here_.size(); }

  /** \brief Room for n normals; never less than before. */
  void reserve(std::size_t n) {
    if (n <= capacity()) return;
    for (std::vector<float>* a : {&here_, &left_, &right_, &up_, &down_, &column_, &row_, &fx_, &fy_, &spacing_,
                                  &normal_x_, &normal_y_, &normal_z_})
      a->resize(n);
    pixels_.resize(n);
  }

  /** \brief One more, for which there must be room. \param view that measured the point  \param depth D^r of that view, with zeros
   *  around it  \param u column of the point's pixel  \param v its row  \param spacing see surfaceDirection() */
  void add(const ViewGeometry& view, const DepthMap& depth, int u, int v, int spacing) {
    const float* here = depth.row(v) + u;
    const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(spacing) * depth.stride();
    const Intrinsics& K = view.intrinsics;
    here_[n_] = *here;
    left_[n_] = here[-spacing];
    right_[n_] = here[spacing];
    up_[n_] = here[-row];
    down_[n_] = here[row];
    column_[n_] = static_cast<float>(u) - K.cx;
    row_[n_] = static_cast<float>(v) - K.cy;
    fx_[n_] = K.fx;
    fy_[n_] = K.fy;
    spacing_[n_] = static_cast<float>(spacing);
    pixels_[n_] = {&view, &depth, u, v, spacing};
    ++n_;
  }

  /** \brief After the last one. */
  void compute() {
    inWideVectors([&] {
      compute(n_, here_.data(), left_.data(), right_.data(), up_.data(), down_.data(), column_.data(), row_.data(),
              fx_.data(), fy_.data(), spacing_.data(), normal_x_.data(), normal_y_.data(), normal_z_.data());
    });
    for (std::size_t k = 0; k < n_; ++k) {
      const Pixel& at = pixels_[k];
      const Vec3 normal = at.view->ideal
                              ? rotate(at.view->T_world_camera, {normal_x_[k], normal_y_[k], normal_z_[k]})
                              : surfaceDirection(*at.view, DepthSurface{*at.depth, *at.view}, at.u, at.v, at.spacing);
      normal_x_[k] = normal.x;
      normal_y_[k] = normal.y;
      normal_z_[k] = normal.z;
    }
  }

  ///@{
  /** \brief Of any length; zero where not known. One for each point, after compute(). */
  const float* x() const { return normal_x_.data(); }
  const float* y() const { return normal_y_.data(); }
  const float* z() const { return normal_z_.data(); }
  ///@}

 private:
  struct Pixel {
    const ViewGeometry* view;
    const DepthMap* depth;
    int u, v, spacing;
  };

  static void compute(std::size_t n, const float* __restrict here, const float* __restrict left,
                      const float* __restrict right, const float* __restrict up, const float* __restrict down,
                      const float* __restrict column, const float* __restrict row, const float* __restrict fx,
                      const float* __restrict fy, const float* __restrict spacing, float* __restrict normal_x,
                      float* __restrict normal_y, float* __restrict normal_z) {
    for (std::size_t k = 0; k < n; ++k) {
      const DepthCross z{here[k], left[k], right[k], up[k], down[k]};
      const Vec3 normal = idealNormal(z, column[k], row[k], fx[k], fy[k], spacing[k]);
      normal_x[k] = normal.x;
      normal_y[k] = normal.y;
      normal_z[k] = normal.z;
    }
  }

  std::size_t n_{0};
  std::vector<float> here_, left_, right_, up_, down_;  // depth, metres
  std::vector<float> column_, row_;                     // of the pixels, from the principal point
  std::vector<float> fx_, fy_, spacing_;                // pixels
  std::vector<float> normal_x_, normal_y_, normal_z_;
  std::vector<Pixel> pixels_;
};

}  // namespace host
}  // namespace fuse_flow
