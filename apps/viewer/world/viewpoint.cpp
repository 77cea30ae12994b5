#include "viewer/world/viewpoint.h"

#include <algorithm>
#include <cmath>

namespace fuse_flow::viewing {
namespace {

constexpr double kAside = 0.45;    // radians, from the first camera's direction …
constexpr double kAbove = 0.25;    // … and upwards: the parallax shows that it is no photograph
constexpr double kDistance = 2.2;  // radii of the cloud, for all of it …
constexpr double kShown = 0.6;     // … of which the view then has that much to either side
constexpr double kWithin = 0.5;    // radii: a camera nearer to the middle than that stands within the cloud
constexpr double kWidest = 65;     // degrees

/** \brief Of each coordinate, which a few far-off points do not move as they move the mean. */
Eigen::Vector3d median(const Cloud& cloud) {
  Eigen::Vector3d result = Eigen::Vector3d::Zero();
  if (cloud.empty()) return result;
  std::vector<float> values(cloud.size());
  for (int axis = 0; axis < 3; ++axis) {
    std::transform(cloud.begin(), cloud.end(), values.begin(), [axis](const PointFused& p) { return p.data[axis]; });
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    result[axis] = static_cast<double>(*middle);
  }
  return result;
}

/** \brief Nine of ten points lie within this of a place. */
double radiusAround(const Eigen::Vector3d& centre, const Cloud& cloud) {
  if (cloud.empty()) return 1;
  std::vector<double> distances(cloud.size());
  std::transform(cloud.begin(), cloud.end(), distances.begin(),
                 [&](const PointFused& p) { return (p.getVector3fMap().cast<double>() - centre).norm(); });
  const auto most = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() * 9 / 10);
  std::nth_element(distances.begin(), most, distances.end());
  return std::max(1e-3, *most);
}

}  // namespace

Viewpoint startViewpoint(const Cloud& cloud, const std::vector<Camera>& cameras) {
  Viewpoint view;
  view.at = median(cloud);
  Eigen::Vector3d up = Eigen::Vector3d::Zero(), towards = Eigen::Vector3d::UnitX();
  for (const Camera& camera : cameras) up -= camera.T_world_camera.linear().col(1);  // y points down
  if (up.norm() > 0.1) view.up = up.normalized();
  if (!cameras.empty()) towards = cameras.front().T_world_camera.translation() - view.at;
  Eigen::Vector3d level = towards - towards.dot(view.up) * view.up;
  if (level.norm() < 1e-6) level = view.up.unitOrthogonal();
  level.normalize();
  const Eigen::Vector3d aside = Eigen::AngleAxisd(kAside, view.up) * level;
  const Eigen::Vector3d direction = std::cos(kAbove) * aside + std::sin(kAbove) * view.up;
  const double radius = radiusAround(view.at, cloud);
  double distance = kDistance * radius;
  const double reach = towards.norm();
  if (!cameras.empty() && reach > kWithin * radius) distance = std::min(distance, reach);  // else it looks outwards
  view.from = view.at + distance * direction;
  view.angle = std::clamp(2 * std::atan(kShown * radius / distance) * 180 / M_PI, view.angle, kWidest);
  return view;
}

Viewpoint lookingAtAllOf(const Eigen::AlignedBox3d& box, const Viewpoint& view) {
  const double half = view.angle / 2 * M_PI / 180;
  Viewpoint result = view;
  result.at = box.center();
  result.from = result.at + box.diagonal().norm() / 2 / std::sin(half) * (view.from - view.at).normalized();
  return result;
}

}  // namespace fuse_flow::viewing
