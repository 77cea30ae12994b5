#pragma once

#include <fuse_flow/rig_frame.h>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief What follows from one camera's calibration alone. */
struct ViewGeometry {
  Intrinsics intrinsics;
  RigidTransform T_world_camera;
  RigidTransform T_camera_world;
  RigidTransform T_color_depth;
  /** \brief Of the ideal lens; see locate(). */
  ProjectionMatrix P;
  /** \brief The other cameras, nearest first: the order in which a point asks them (section 5 (2) b). */
  std::vector<std::uint32_t> neighbours;

  void assign(const Camera& camera) {
    intrinsics = camera.intrinsics;
    T_world_camera = toRigidTransform(camera.T_world_camera);
    T_camera_world = toRigidTransform(camera.T_world_camera.inverse());
    if (camera.color) T_color_depth = toRigidTransform(camera.color->T_depth_color.inverse());
    P = projectionMatrix(intrinsics, T_camera_world);
    ideal_ = isIdeal(intrinsics.distortion);
    const auto w = static_cast<std::size_t>(intrinsics.width);
    const auto h = static_cast<std::size_t>(intrinsics.height);
    column_x_.resize(w);
    for (std::size_t u = 0; u < w; ++u) column_x_[u] = (static_cast<float>(u) - intrinsics.cx) / intrinsics.fx;
    rays_.resize(ideal_ ? 0 : w * h);
    if (!ideal_)
      for (std::size_t v = 0; v < h; ++v)
        for (std::size_t u = 0; u < w; ++u)
          rays_[v * w + u] = unproject(intrinsics, {static_cast<float>(u), static_cast<float>(v)});
    max_squared_radius_ = 0;
    for (const Ray& r : rays_) max_squared_radius_ = std::max(max_squared_radius_, r.x * r.x + r.y * r.y);
  }

  /** \brief The pixel nearest to a point in the world frame, and the point's depth. False where the image does not
   *  reach. */
  bool locate(const Vec3& p_W, int& u, int& v, float& z) const {
    Vec3 q = P * p_W;
    z = q.z;
    if (!(z > 0)) return false;
    if (!ideal_) {
      const Vec3 p_C = T_camera_world * p_W;
      // Far outside the field of view the lens polynomial folds back into the image.
      if (p_C.x * p_C.x + p_C.y * p_C.y > 1.02f * max_squared_radius_ * z * z) return false;
      const Pixel pixel = project(intrinsics, p_C);
      q = {pixel.u * z, pixel.v * z, z};
    }
    const float inverse_z = 1.0f / z;
    const float x = q.x * inverse_z + 0.5f;
    const float y = q.y * inverse_z + 0.5f;
    // Compared as floats, so that a far-off projection never overflows the integer.
    if (!((x >= 0) & (x < static_cast<float>(intrinsics.width)) & (y >= 0) &
          (y < static_cast<float>(intrinsics.height))))
      return false;
    u = static_cast<int>(x);
    v = static_cast<int>(y);
    return true;
  }

  /** \brief unproject() of an integer pixel, from a table. */
  Ray ray(int u, int v) const {
    if (ideal_)
      return {column_x_[static_cast<std::size_t>(u)], (static_cast<float>(v) - intrinsics.cy) / intrinsics.fy};
    return rays_[static_cast<std::size_t>(v) * static_cast<std::size_t>(intrinsics.width) +
                 static_cast<std::size_t>(u)];
  }

 private:
  bool ideal_{true};
  float max_squared_radius_{0};
  std::vector<float> column_x_;
  std::vector<Ray> rays_;
};

/** \brief The geometry of all cameras of a rig; recomputed only when the calibration changes. */
class RigGeometry {
 public:
  void update(const std::vector<Camera>& cameras) {
    if (cameras.size() == cameras_.size() &&
        std::equal(cameras.begin(), cameras.end(), cameras_.begin(), sameCalibration))
      return;
    cameras_ = cameras;
    views_.resize(cameras.size());
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      views_[i].assign(cameras[i]);
      rankNeighbours(i);
    }
  }

  std::size_t size() const { return views_.size(); }
  const ViewGeometry& operator[](std::size_t i) const { return views_[i]; }

 private:
  /** \brief By distance between the centres plus the angle between the optical axes, one radian as one metre; ties by
   *  number. The whole list costs N² log N once per calibration: 64 cameras, well under a millisecond. */
  void rankNeighbours(std::size_t i) {
    std::vector<std::pair<double, std::uint32_t>> ranked;
    const Eigen::Isometry3d& T_i = cameras_[i].T_world_camera;
    for (std::size_t j = 0; j < cameras_.size(); ++j) {
      if (j == i) continue;
      const Eigen::Isometry3d& T_j = cameras_[j].T_world_camera;
      const double cosine = T_i.linear().col(2).dot(T_j.linear().col(2));
      const double angle = std::acos(std::clamp(cosine, -1.0, 1.0));
      ranked.emplace_back((T_i.translation() - T_j.translation()).norm() + angle, static_cast<std::uint32_t>(j));
    }
    std::sort(ranked.begin(), ranked.end());
    views_[i].neighbours.clear();
    for (const auto& [score, j] : ranked) views_[i].neighbours.push_back(j);
  }

  std::vector<Camera> cameras_;
  std::vector<ViewGeometry> views_;
};

}  // namespace host
}  // namespace fuse_flow
