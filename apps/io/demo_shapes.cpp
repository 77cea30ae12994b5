#include "io/demo_shapes.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fuse_flow::io {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double nearest_hit = 1e-6;  // a ray does not meet the surface that it starts on

/** \brief Floor and two walls: the faces x, y, z = corner of the space above and beyond them. */
class Corner : public Shape {
 public:
  Corner(const Vector3d& corner, const Paint& paint) : Shape(paint), corner_(corner) {}

  std::optional<Hit> intersect(const Vector3d& origin, const Vector3d& direction) const override {
    std::optional<Hit> best;
    for (int axis = 0; axis < 3; ++axis) {
      if (direction[axis] >= 0) continue;
      const double t = (corner_[axis] - origin[axis]) / direction[axis];
      if (t > nearest_hit && (!best || t < best->t)) best = Hit{t, Vector3d::Unit(axis)};
    }
    return best;
  }
  double distance(const Vector3d& p_W) const override {
    const Vector3d inside = p_W - corner_;
    const double nearest = inside.minCoeff();
    return nearest >= 0 ? nearest : inside.cwiseMin(0.0).norm();
  }

 private:
  Vector3d corner_;
};

class Sphere : public Shape {
 public:
  Sphere(const Vector3d& centre, double radius, const Paint& paint) : Shape(paint), centre_(centre), radius_(radius) {}

  std::optional<Hit> intersect(const Vector3d& origin, const Vector3d& direction) const override {
    const Vector3d from_centre = origin - centre_;
    const double a = direction.squaredNorm(), b = from_centre.dot(direction),
                 c = from_centre.squaredNorm() - radius_ * radius_;
    const double discriminant = b * b - a * c;
    if (discriminant < 0) return std::nullopt;
    const double t = (-b - std::sqrt(discriminant)) / a;
    if (t <= nearest_hit) return std::nullopt;
    return Hit{t, (from_centre + t * direction) / radius_};
  }
  double distance(const Vector3d& p_W) const override { return std::abs((p_W - centre_).norm() - radius_); }

 private:
  Vector3d centre_;
  double radius_;
};

/** \brief A box turned about the vertical. */
class Box : public Shape {
 public:
  Box(const Vector3d& centre, const Vector3d& half_size, double cos_yaw, double sin_yaw, const Paint& paint)
      : Shape(paint), centre_(centre), half_size_(half_size) {
    R_world_box_ << cos_yaw, -sin_yaw, 0, sin_yaw, cos_yaw, 0, 0, 0, 1;
  }

  std::optional<Hit> intersect(const Vector3d& origin, const Vector3d& direction) const override {
    const Vector3d o = R_world_box_.transpose() * (origin - centre_);
    const Vector3d d = R_world_box_.transpose() * direction;
    double enter = nearest_hit, leave = std::numeric_limits<double>::infinity();
    int face = -1;
    for (int axis = 0; axis < 3; ++axis) {
      const double a = (-half_size_[axis] - o[axis]) / d[axis], b = (half_size_[axis] - o[axis]) / d[axis];
      if (std::min(a, b) > enter) enter = std::min(a, b), face = axis;
      leave = std::min(leave, std::max(a, b));
    }
    if (face < 0 || enter > leave) return std::nullopt;
    return Hit{enter, R_world_box_ * Vector3d::Unit(face) * (d[face] > 0 ? -1.0 : 1.0)};
  }
  double distance(const Vector3d& p_W) const override {
    const Vector3d outside = (R_world_box_.transpose() * (p_W - centre_)).cwiseAbs() - half_size_;
    return outside.maxCoeff() <= 0 ? -outside.maxCoeff() : outside.cwiseMax(0.0).norm();
  }

 private:
  Vector3d centre_, half_size_;
  Eigen::Matrix3d R_world_box_;
};

/** \brief An upright cylinder with its two lids. */
class Cylinder : public Shape {
 public:
  Cylinder(const Vector3d& centre, double radius, double half_height, const Paint& paint)
      : Shape(paint), centre_(centre), radius_(radius), half_height_(half_height) {}

  std::optional<Hit> intersect(const Vector3d& origin, const Vector3d& direction) const override {
    const Vector3d o = origin - centre_;
    const Vector2d o2 = o.head<2>(), d2 = direction.head<2>();
    std::optional<Hit> best;
    const double a = d2.squaredNorm(), b = o2.dot(d2), c = o2.squaredNorm() - radius_ * radius_;
    const double discriminant = b * b - a * c;
    if (a > 0 && discriminant >= 0) {
      const double t = (-b - std::sqrt(discriminant)) / a;
      const Vector3d p = o + t * direction;
      if (t > nearest_hit && std::abs(p.z()) <= half_height_) best = Hit{t, Vector3d(p.x(), p.y(), 0) / radius_};
    }
    const double lid = direction.z() < 0 ? half_height_ : -half_height_;
    const double t = (lid - o.z()) / direction.z();
    if (t > nearest_hit && (o2 + t * d2).norm() <= radius_ && (!best || t < best->t))
      best = Hit{t, Vector3d(0, 0, lid > 0 ? 1 : -1)};
    return best;
  }
  double distance(const Vector3d& p_W) const override {
    const Vector3d p = p_W - centre_;
    const Vector2d outside(p.head<2>().norm() - radius_, std::abs(p.z()) - half_height_);
    return outside.maxCoeff() <= 0 ? -outside.maxCoeff() : outside.cwiseMax(0.0).norm();
  }

 private:
  Vector3d centre_;
  double radius_, half_height_;
};

/** \brief The rolling ball's y: 0.1 m a frame, back and forth over 1.2 m. */
double rollingBallY(std::size_t frame) {
  const auto step = static_cast<int>(frame % 24);
  return -0.6 + 0.1 * (step < 12 ? step : 24 - step);
}

}  // namespace

Rgb8 Shape::colorAt(const Vector3d& p_W) const {
  // Shifted, so that no surface of the scene lies in a plane where the pattern changes.
  const Vector3d cell = (p_W / paint_.size + Vector3d::Constant(0.13)).array().floor();
  return static_cast<long>(cell.sum()) % 2 == 0 ? paint_.first : paint_.second;
}

DemoScene::DemoScene(std::size_t frame) {
  const Paint room{{186, 178, 160}, {140, 150, 158}, 0.4}, table{{150, 98, 52}, {120, 74, 36}, 0.15};
  const Paint ball{{200, 60, 50}, {235, 220, 200}, 0.09}, column{{60, 120, 70}, {150, 190, 110}, 0.1};
  const Paint rolling{{50, 80, 190}, {230, 200, 60}, 0.1};
  shapes_.push_back(std::make_unique<Corner>(Vector3d(-1.2, -1.2, 0), room));
  shapes_.push_back(std::make_unique<Box>(Vector3d(-0.2, -0.1, 0.2), Vector3d(0.45, 0.3, 0.2), 0.96, 0.28, table));
  shapes_.push_back(std::make_unique<Sphere>(Vector3d(-0.05, 0.0, 0.56), 0.16, ball));
  shapes_.push_back(std::make_unique<Cylinder>(Vector3d(-0.5, 0.6, 0.45), 0.14, 0.45, column));
  shapes_.push_back(std::make_unique<Sphere>(Vector3d(0.65, rollingBallY(frame), 0.15), 0.15, rolling));
}

std::optional<DemoScene::SceneHit> DemoScene::trace(const Vector3d& origin, const Vector3d& direction) const {
  std::optional<SceneHit> best;
  for (const auto& shape : shapes_) {
    const std::optional<Hit> hit = shape->intersect(origin, direction);
    if (hit && (!best || hit->t < best->t)) best = SceneHit{*hit, shape.get()};
  }
  return best;
}

bool DemoScene::sees(const Vector3d& from, const Vector3d& to) const {
  const std::optional<SceneHit> hit = trace(from, to - from);
  return !hit || hit->t > 1 - 1e-3;
}

double DemoScene::distance(const Vector3d& p_W) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& shape : shapes_) nearest = std::min(nearest, shape->distance(p_W));
  return nearest;
}

}  // namespace fuse_flow::io
