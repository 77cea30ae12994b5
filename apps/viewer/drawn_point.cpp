#include "viewer/drawn_point.h"

#include <limits>

namespace fuse_flow::viewing {

std::optional<std::size_t> pointDrawnAt(const Cloud& cloud, const Eigen::Matrix4f& projection,
                                        const Eigen::Vector2f& at, const Eigen::Vector2f& radius) {
  std::optional<std::size_t> nearest;
  float nearest_depth = std::numeric_limits<float>::infinity();
  for (std::size_t k = 0; k < cloud.size(); ++k) {
    const Eigen::Vector4f p = projection * cloud[k].getVector4fMap();
    if (!(p.w() > 0) || !(std::abs(p.z()) <= p.w())) continue;  // behind the viewer, or clipped
    const Eigen::Vector2f offset = (p.head<2>() / p.w() - at).cwiseQuotient(radius);
    const float depth = p.z() / p.w();
    if (offset.squaredNorm() > 1 || depth >= nearest_depth) continue;
    nearest = k;
    nearest_depth = depth;
  }
  return nearest;
}

}  // namespace fuse_flow::viewing
