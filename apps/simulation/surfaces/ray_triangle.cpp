#include "simulation/surfaces/ray_triangle.h"

#include "simulation/pi.h"
#include "simulation/portable_math.h"

#include <algorithm>

namespace fuse_flow::simulation {

double angleAround(const Eigen::Vector3d& point, const Triangle& triangle, double reach) {
  using Eigen::Vector3d;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3d corner = triangle[k].cast<double>();
    if ((point - corner).norm() > reach) continue;
    const Vector3d a = triangle[(k + 1) % 3].cast<double>() - corner, b = triangle[(k + 2) % 3].cast<double>() - corner;
    return portable::atan2(a.cross(b).norm(), a.dot(b));
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3d from = triangle[k].cast<double>(), edge = triangle[(k + 1) % 3].cast<double>() - from;
    if ((point - from).cross(edge).norm() <= reach * edge.norm()) return kPi;
  }
  return 2 * kPi;
}

}  // namespace fuse_flow::simulation
