#include "viewer/world/drawn_point.h"

#include <Eigen/Geometry>

#include <limits>

namespace fuse_flow::viewing {
namespace {

/** \brief Where a point is drawn, −1 … 1 in each axis; absent: behind the viewer, or clipped. */
std::optional<Eigen::Vector3f> drawnAt(const PointFused& point, const Eigen::Matrix4f& projection) {
  const Eigen::Vector4f p = projection * point.getVector4fMap();
  if (!(p.w() > 0) || !(std::abs(p.z()) <= p.w())) return std::nullopt;
  return Eigen::Vector3f(p.head<3>() / p.w());
}

}  // namespace

std::optional<std::size_t> pointDrawnAt(const Cloud& cloud, const Eigen::Matrix4f& projection,
                                        const Eigen::Vector2f& at, const Eigen::Vector2f& radius) {
  std::optional<std::size_t> nearest;
  float nearest_depth = std::numeric_limits<float>::infinity();
  for (std::size_t k = 0; k < cloud.size(); ++k) {
    const std::optional<Eigen::Vector3f> p = drawnAt(cloud[k], projection);
    if (!p || p->z() >= nearest_depth || (p->head<2>() - at).cwiseQuotient(radius).squaredNorm() > 1) continue;
    nearest = k;
    nearest_depth = p->z();
  }
  return nearest;
}

std::vector<std::size_t> pointsDrawnIn(const Cloud& cloud, const Eigen::Matrix4f& projection,
                                       const Eigen::Vector2f& low, const Eigen::Vector2f& high) {
  std::vector<std::size_t> inside;
  const Eigen::AlignedBox2f rectangle(low, high);
  for (std::size_t k = 0; k < cloud.size(); ++k) {
    const std::optional<Eigen::Vector3f> p = drawnAt(cloud[k], projection);
    if (p && rectangle.contains(p->head<2>())) inside.push_back(k);
  }
  return inside;
}

}  // namespace fuse_flow::viewing
