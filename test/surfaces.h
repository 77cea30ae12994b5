#pragma once

/** \file
 *  \brief Surfaces that rays meet, for scenes whose geometry is known by hand. */

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

namespace scenes {

using Eigen::Vector3d;

/** \brief The smallest t > 0 with origin + t · direction on the surface; 0 where the ray meets nothing. */
using Surface = std::function<double(const Vector3d& origin, const Vector3d& direction)>;

/** \brief Points with normal · p = offset. */
inline Surface plane(const Vector3d& normal, double offset) {
  return [=](const Vector3d& origin, const Vector3d& direction) {
    const double slope = normal.dot(direction);
    const double t = slope != 0 ? (offset - normal.dot(origin)) / slope : 0;
    return t > 0 ? t : 0;
  };
}

/** \brief The piece of the plane z = distance with |x − cx| ≤ half and |y − cy| ≤ half. */
inline Surface square(double cx, double cy, double distance, double half) {
  return [=](const Vector3d& origin, const Vector3d& direction) {
    const double t = direction.z() != 0 ? (distance - origin.z()) / direction.z() : 0;
    const Vector3d p = origin + t * direction;
    return t > 0 && std::abs(p.x() - cx) <= half && std::abs(p.y() - cy) <= half ? t : 0.0;
  };
}

inline Surface sphere(const Vector3d& centre, double radius) {
  return [=](const Vector3d& origin, const Vector3d& direction) {
    const double a = direction.squaredNorm();
    const double b = direction.dot(origin - centre);
    const double discriminant = b * b - a * ((origin - centre).squaredNorm() - radius * radius);
    return discriminant > 0 ? std::max(0.0, (-b - std::sqrt(discriminant)) / a) : 0.0;
  };
}

/** \brief The first of several surfaces that a ray meets. */
inline Surface nearest(const std::vector<Surface>& surfaces) {
  return [=](const Vector3d& origin, const Vector3d& direction) {
    double first = 0;
    for (const Surface& surface : surfaces) {
      const double t = surface(origin, direction);
      if (t > 0 && (first == 0 || t < first)) first = t;
    }
    return first;
  };
}

}  // namespace scenes
