#include "simulation/rig_layout.h"

#include "simulation/pi.h"
#include "simulation/portable_math.h"

#include <fuse_flow/recordings/error.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <regex>

namespace fuse_flow::simulation {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

constexpr double kFromWall = 0.15;  // a camera's own depth, metres

struct Layout {
  bool walls;
  int cameras;
  bool narrow;
};

std::optional<Layout> parse(const std::string& rig) {
  std::smatch match;
  if (!std::regex_match(rig, match, std::regex("(ring|walls)-([0-9]{1,2})(-narrow)?"))) return std::nullopt;
  const int cameras = std::stoi(match[2]);
  if (cameras < 1 || cameras > 64) return std::nullopt;
  return Layout{match[1] == "walls", cameras, match[3].matched};
}

Layout layoutOf(const std::string& rig) {
  if (const std::optional<Layout> layout = parse(rig)) return *layout;
  throw io::InputError("rig '" + rig +
                       "' is not known; must be ring-N or walls-N, N from 1 to 64, or with -narrow behind it");
}

/** \brief Where camera k looks: the middle of the subject, or a part of it that is its own. */
Vector3d target(const Layout& layout, int k, const Vector3d& from, const AlignedBox3d& subject) {
  const Vector3d centre = subject.center();
  if (!layout.narrow) return centre;
  const Vector3d half = 0.5 * subject.sizes();
  const Vector3d forward = (centre - from).normalized();
  const Vector3d sideways = forward.cross(Vector3d::UnitZ()).normalized();
  const double side = k % 2 == 0 ? 1.0 : -1.0;
  const double height = k / 2 % 2 == 0 ? 1.0 : -1.0;
  const double width = std::fabs(sideways.x()) * half.x() + std::fabs(sideways.y()) * half.y();
  return centre + 0.5 * side * width * sideways + 0.5 * height * half.z() * Vector3d::UnitZ();
}

Vector3d onRing(const Layout& layout, int k, const AlignedBox3d& subject) {
  const double step = layout.cameras <= 3 ? kPi / 3 : 2 * kPi / layout.cameras;
  const double angle = 0.3 + k * step;  // not along the walls
  const double across = subject.sizes().head<2>().norm();
  const double radius = (layout.narrow ? 0.6 : 1.0) * (0.5 * across + 1.1);
  const double lift = k % 2 == 0 ? 0.15 : 0.45;  // of the radius, above the middle of the subject
  return subject.center() + radius * Vector3d(portable::cos(angle), portable::sin(angle), lift);
}

Vector3d onWalls(const Layout& layout, int k, const AlignedBox3d& room) {
  const Vector3d size = room.sizes();
  double along = (k + 0.37) / layout.cameras * 2 * (size.x() + size.y());
  Vector3d place(room.min().x(), room.min().y(), std::min(2.2, room.max().z() - 0.1));
  for (int wall = 0; wall < 4; ++wall) {
    const double length = wall % 2 == 0 ? size.x() : size.y();
    const double part = std::min(along, length);
    const Vector3d direction = wall == 0   ? Vector3d::UnitX()
                               : wall == 1 ? Vector3d::UnitY()
                               : wall == 2 ? Vector3d(-Vector3d::UnitX())
                                           : Vector3d(-Vector3d::UnitY());
    place += part * direction;
    along -= part;
  }
  return place;
}

}  // namespace

Eigen::Isometry3d lookAt(const Vector3d& from, const Vector3d& at) {
  const Vector3d forward = (at - from).normalized();
  Vector3d right = forward.cross(Vector3d::UnitZ());
  right = right.norm() > 1e-6 ? Vector3d(right.normalized()) : Vector3d(Vector3d::UnitX());
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear().col(0) = right;
  T.linear().col(1) = forward.cross(right);
  T.linear().col(2) = forward;
  T.translation() = from;
  return T;
}

bool isRigName(const std::string& rig) { return parse(rig).has_value(); }

std::vector<Eigen::Isometry3d> placeCameras(const std::string& rig, const Scene& scene) {
  const Layout layout = layoutOf(rig);
  const AlignedBox3d subject = scene.subject().cast<double>();
  const AlignedBox3d room = scene.room().cast<double>();
  const Vector3d low = room.min().array() + kFromWall, high = room.max().array() - kFromWall;
  std::vector<Eigen::Isometry3d> poses;
  for (int k = 0; k < layout.cameras; ++k) {
    const Vector3d place = layout.walls ? onWalls(layout, k, room) : onRing(layout, k, subject);
    const Vector3d inside = place.cwiseMax(low).cwiseMin(high);
    poses.push_back(lookAt(inside, target(layout, k, inside, subject)));
  }
  return poses;
}

}  // namespace fuse_flow::simulation
