#pragma once

#include <fuse_flow/impl/calibration/alignment_view.hpp>

#include <Eigen/Geometry>

#include <vector>

namespace fuse_flow {
namespace host {

/** \brief The directions in which most of a view's surfaces face, the most frequent first; camera's frame. Of rooms: floor,
 *  walls, table tops. */
class SurfaceDirections {
 public:
  explicit SurfaceDirections(const AlignmentView& view) {
    std::vector<Eigen::Vector3d> left = normals(view);
    const std::size_t enough = left.size() / kSmallestShare;
    while (directions_.size() < kMost && !left.empty()) {
      const Eigen::Vector3d direction = climb(left, densest(left));
      const std::size_t before = left.size();
      left.erase(std::remove_if(left.begin(), left.end(), [&](const auto& n) { return n.dot(direction) > kApart; }),
                 left.end());
      if (before - left.size() < std::max<std::size_t>(enough, 1)) break;
      directions_.push_back(direction);
    }
  }

  const std::vector<Eigen::Vector3d>& directions() const { return directions_; }

 private:
  static std::vector<Eigen::Vector3d> normals(const AlignmentView& view) {
    std::vector<Eigen::Vector3d> result;
    for (int v = 0; v < view.height(); v += 2)
      for (int u = 0; u < view.width(); u += 2) {
        const Vec3& n = view.normal(u, v);
        if (squaredNorm(n) > 0) result.emplace_back(n.x, n.y, n.z);
      }
    return result;
  }

  /** \brief Of some of the normals, the one with most others around it. */
  static Eigen::Vector3d densest(const std::vector<Eigen::Vector3d>& normals) {
    const std::size_t stride = 1 + normals.size() / kTries;
    std::size_t most = 0, best = 0;
    for (std::size_t k = 0; k < normals.size(); k += stride) {
      std::size_t count = 0;
      for (const Eigen::Vector3d& n : normals) count += n.dot(normals[k]) > kNear ? 1 : 0;
      if (count > most) {
        most = count;
        best = k;
      }
    }
    return normals[best];
  }

  /** \brief Mean shift. */
  static Eigen::Vector3d climb(const std::vector<Eigen::Vector3d>& normals, Eigen::Vector3d direction) {
    for (int iteration = 0; iteration < 5; ++iteration) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (const Eigen::Vector3d& n : normals)
        if (n.dot(direction) > kNear) sum += n;
      if (!(sum.squaredNorm() > 0)) break;
      direction = sum.normalized();
    }
    return direction;
  }

  static constexpr std::size_t kMost = 7;
  static constexpr std::size_t kSmallestShare = 50;  ///< one in so many normals
  static constexpr std::size_t kTries = 150;
  static constexpr double kNear = 0.985;  ///< cosine of 10°
  static constexpr double kApart = 0.94;  ///< cosine of 20°

  std::vector<Eigen::Vector3d> directions_;
};

}  // namespace host
}  // namespace fuse_flow
