#pragma once

#include <fuse_flow/math/view.h>

#include <cmath>

namespace fuse_flow {
namespace host {

/** \brief An axis-aligned box in the world frame, metres. */
struct Bounds {
  Vec3 centre{};
  Vec3 half{};  ///< half its sides; ≥ 0
};

/** \brief The half-spaces between which lies all that a view can see. A box beyond one of them is none of the view's: most of a
 *  rig's cameras do not see most of its cells. */
class ViewFrustum {
 public:
  ViewFrustum() = default;

  explicit ViewFrustum(const ViewModel& view) {
    const float* m = view.P.m;
    if (view.ideal) {
      // ViewModel::place(): 0 ≤ x < width, x = q.x / q.z + ½, q = P p; the same of y
      const auto width = static_cast<float>(view.intrinsics.width), height = static_cast<float>(view.intrinsics.height);
      set(0, m, 1, 0.5f, m + 8);
      set(1, m, -1, width - 0.5f, m + 8);
      set(2, m + 4, 1, 0.5f, m + 8);
      set(3, m + 4, -1, height - 0.5f, m + 8);
    } else {
      // ViewModel::foldsBack(): a lens with distortion sees nothing outside of a cone
      const RigidTransform& T = view.T_camera_world;
      const float along_x[4] = {T.r[0], T.r[1], T.r[2], T.t.x}, along_y[4] = {T.r[3], T.r[4], T.r[5], T.t.y};
      const float widest = std::sqrt(1.03f * view.max_squared_radius);
      set(0, along_x, 1, widest, m + 8);
      set(1, along_x, -1, widest, m + 8);
      set(2, along_y, 1, widest, m + 8);
      set(3, along_y, -1, widest, m + 8);
    }
    set(4, m, 0, 1, m + 8);
  }

  /** \brief False where the view sees nothing of the box; where it does, true, and in places where it does not. Leaves room for the
   *  rounding of ViewModel::locate(). */
  FUSE_FLOW_HD bool mayShow(const Bounds& box) const {
    const Vec3 &c = box.centre, &h = box.half;
    const float rounding = 1e-5f * (std::fabs(c.x) + std::fabs(c.y) + std::fabs(c.z));
    bool inside = true;
    for (int k = 0; k < kPlanes; ++k) {
      const float distance = x_[k] * c.x + y_[k] * c.y + z_[k] * c.z + d_[k];
      const float reach = std::fabs(x_[k]) * h.x + std::fabs(y_[k]) * h.y + std::fabs(z_[k]) * h.z;
      inside &= distance + reach + rounding + 1e-5f * std::fabs(d_[k]) >= 0;
    }
    return inside;
  }

 private:
  static constexpr int kPlanes = 8;  ///< five, and three that hold everything: whole vectors

  /** \brief The plane a · row + b · depth, of coefficients of (x, y, z, 1), at unit distance. */
  void set(int k, const float* row, float a, float b, const float* depth) {
    double plane[4];
    for (int n = 0; n < 4; ++n) plane[n] = static_cast<double>(a) * row[n] + static_cast<double>(b) * depth[n];
    const double norm = std::sqrt(plane[0] * plane[0] + plane[1] * plane[1] + plane[2] * plane[2]);
    x_[k] = static_cast<float>(plane[0] / norm);
    y_[k] = static_cast<float>(plane[1] / norm);
    z_[k] = static_cast<float>(plane[2] / norm);
    d_[k] = static_cast<float>(plane[3] / norm);
  }

  float x_[kPlanes]{}, y_[kPlanes]{}, z_[kPlanes]{}, d_[kPlanes]{};
};

}  // namespace host
}  // namespace fuse_flow
