#include "simulation/rig_layout.h"

#include "simulation/pi.h"
#include "simulation/portable_math.h"

#include <fuse_flow/recordings/error.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <regex>

namespace fuse_flow::simulation {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

constexpr double kFromWall = 0.15;        // a camera's own depth, metres
constexpr double kSurroundRadius = 0.15;  // of cameras that look outward, metres
constexpr double kRowStep = 0.12;         // from one camera of a row to the next, metres
constexpr int kLongestRow = 8;            // cameras; more would not fit into the rooms

enum class Shape { Ring, Walls, Arc, Row, Surround };

struct Layout {
  Shape shape;
  int cameras;
  bool narrow;  // rings and walls
  bool level;   // arcs
};

std::optional<Layout> parse(const std::string& rig) {
  std::smatch match;
  if (!std::regex_match(rig, match, std::regex("(ring|walls|arc|row|surround)-([0-9]{1,2})(-narrow)?(-level)?")))
    return std::nullopt;
  const std::map<std::string, Shape> shapes = {{"ring", Shape::Ring},
                                               {"walls", Shape::Walls},
                                               {"arc", Shape::Arc},
                                               {"row", Shape::Row},
                                               {"surround", Shape::Surround}};
  const Shape shape = shapes.at(match[1]);
  const bool around_subject = shape == Shape::Ring || shape == Shape::Walls;
  const int cameras = std::stoi(match[2]);
  if (cameras < (around_subject ? 1 : 2) || cameras > (shape == Shape::Row ? kLongestRow : 64)) return std::nullopt;
  if ((match[3].matched && !around_subject) || (match[4].matched && shape != Shape::Arc)) return std::nullopt;
  return Layout{shape, cameras, match[3].matched, match[4].matched};
}

Layout layoutOf(const std::string& rig) {
  if (const std::optional<Layout> layout = parse(rig)) return *layout;
  throw io::InputError("rig '" + rig + "' is not known; must be " + rigNames());
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

/** \brief How far from the vertical axis of the subject cameras stand where there is space, metres. */
double wideRadius(const AlignedBox3d& subject) { return 0.5 * subject.sizes().head<2>().norm() + 1.1; }

Vector3d onRing(const Layout& layout, int k, const AlignedBox3d& subject) {
  const double step = layout.cameras <= 3 ? kPi / 3 : 2 * kPi / layout.cameras;
  const double angle = 0.3 + k * step;  // not along the walls
  const double radius = (layout.narrow ? 0.6 : 1.0) * wideRadius(subject);
  const double lift = k % 2 == 0 ? 0.15 : 0.45;  // of the radius, above the middle of the subject
  return subject.center() + radius * Vector3d(portable::cos(angle), portable::sin(angle), lift);
}

/** \brief From the middle of the subject to camera k of an arc of radius 1. */
Vector3d arcDirection(const Layout& layout, int k) {
  // Seen from the subject, neighbours are 12° apart by their azimuths and heights, second neighbours by their azimuths:
  // views that are farther apart show a surface too differently to be matched.
  const double step = std::min(6 * kPi / 180, 2 * kPi / layout.cameras);
  // The middle of the arc is near the x axis, along which the rooms are longest, but not along the walls.
  const double angle = 0.1 + (k - 0.5 * (layout.cameras - 1)) * step;
  const double lift = layout.level ? 0.3 : k % 2 == 0 ? 0.2 : 0.4;
  return {portable::cos(angle), portable::sin(angle), lift};
}

/** \brief How many times a vector from inside of a box fits into it. */
double reach(const Vector3d& from, const Vector3d& direction, const Vector3d& low, const Vector3d& high) {
  double times = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const double side = direction[axis] > 0 ? high[axis] : low[axis];
    if (std::fabs(direction[axis]) > 0) times = std::min(times, (side - from[axis]) / direction[axis]);
  }
  return times;
}

/** \brief One radius for all cameras: in a small room a smaller one keeps the angles between them, where moving each to
 *  the wall would not. */
double arcRadius(const Layout& layout, const AlignedBox3d& subject, const Vector3d& low, const Vector3d& high) {
  double radius = wideRadius(subject);
  for (int k = 0; k < layout.cameras; ++k)
    radius = std::min(radius, reach(subject.center(), arcDirection(layout, k), low, high));
  return radius;
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

std::string rigNames() {
  return "ring-N or walls-N, N from 1 to 64, or with -narrow behind it; or arc-N, N from 2 to 64, or with -level; or "
         "row-N, N from 2 to 8; or surround-N, N from 2 to 64";
}

namespace {

std::vector<Eigen::Isometry3d> lookingOutward(int cameras, const Vector3d& middle) {
  std::vector<Eigen::Isometry3d> poses;
  for (int k = 0; k < cameras; ++k) {
    const double angle = 0.3 + k * 2 * kPi / cameras;  // not along the walls
    const Vector3d outward(portable::cos(angle), portable::sin(angle), 0);
    const Vector3d place = middle + kSurroundRadius * outward;
    poses.push_back(lookAt(place, place + outward));
  }
  return poses;
}

/** \brief From left to right, with one orientation: their images are rectified as they are. */
std::vector<Eigen::Isometry3d> inRow(int cameras, const AlignedBox3d& subject, const Vector3d& low,
                                     const Vector3d& high) {
  const Layout middle_of_arc{Shape::Arc, 1, false, true};
  const double radius = arcRadius(middle_of_arc, subject, low, high);
  const Eigen::Isometry3d middle = lookAt(subject.center() + radius * arcDirection(middle_of_arc, 0), subject.center());
  std::vector<Eigen::Isometry3d> poses;
  for (int k = 0; k < cameras; ++k) {
    poses.push_back(middle);
    poses.back().translation() += kRowStep * (k - 0.5 * (cameras - 1)) * middle.linear().col(0);
  }
  return poses;
}

}  // namespace

std::vector<Eigen::Isometry3d> placeCameras(const std::string& rig, const Scene& scene) {
  const Layout layout = layoutOf(rig);
  if (layout.shape == Shape::Surround) {
    const std::optional<Eigen::Vector3f> middle = scene.lookout();
    if (!middle)
      throw io::InputError("rig '" + rig +
                           "' needs a scene that leaves a place free for cameras that look outward: passerby");
    return lookingOutward(layout.cameras, middle->cast<double>());
  }
  const AlignedBox3d subject = scene.subject().cast<double>();
  const AlignedBox3d room = scene.room().cast<double>();
  const Vector3d low = room.min().array() + kFromWall, high = room.max().array() - kFromWall;
  if (layout.shape == Shape::Row) return inRow(layout.cameras, subject, low, high);
  const double arc_radius = layout.shape == Shape::Arc ? arcRadius(layout, subject, low, high) : 0;
  const auto placeOf = [&](int k) -> Vector3d {
    switch (layout.shape) {
      case Shape::Walls:
        return onWalls(layout, k, room);
      case Shape::Arc:
        return subject.center() + arc_radius * arcDirection(layout, k);
      default:
        return onRing(layout, k, subject);
    }
  };
  std::vector<Eigen::Isometry3d> poses;
  for (int k = 0; k < layout.cameras; ++k) {
    const Vector3d place = placeOf(k);
    const Vector3d inside = place.cwiseMax(low).cwiseMin(high);
    poses.push_back(lookAt(inside, target(layout, k, inside, subject)));
  }
  return poses;
}

}  // namespace fuse_flow::simulation
