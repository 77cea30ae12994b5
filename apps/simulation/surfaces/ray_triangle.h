#pragma once

#include <Eigen/Core>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

/** \file
 *  \brief Where a ray meets a triangle, and which of its points is nearest to a place: in double and in a fixed order, so that the
 *  answer is the same on every machine. */

namespace fuse_flow::simulation {

/** \brief Corners, metres; counter-clockwise seen from outside. */
using Triangle = std::array<Eigen::Vector3f, 3>;

/** \brief A moment of a motion that is given by steps: after a step, by this share of the way to the next; in [0, 1). */
struct BetweenSteps {
  std::size_t step{0};
  float share{0};
};

/** \brief Triangles by number, and by how much the boxes that Embree gets are larger than they, metres: more than what its single
 *  precision rounds. */
struct Triangles {
  /** \brief At the first step. */
  std::vector<Triangle> all;
  /** \brief Those that move come last … */
  std::uint32_t first_moving{0};
  /** \brief … and are here at each further step; empty: an instant. Between two steps corners move on straight lines. */
  std::vector<std::vector<Triangle>> later;
  float margin{0};

  const Triangle& at(std::uint32_t number, std::size_t step) const {
    return step == 0 || number < first_moving ? all[number] : later[step - 1][number - first_moving];
  }
  Triangle at(std::uint32_t number, const BetweenSteps& moment) const {
    const Triangle& here = at(number, moment.step);
    if (!(moment.share > 0) || number < first_moving) return here;  // what stands still stays where it is, to the bit
    const Triangle& next = at(number, moment.step + 1);
    Triangle between;
    for (std::size_t k = 0; k < 3; ++k) between[k] = (1 - moment.share) * here[k] + moment.share * next[k];
    return between;
  }
};

/** \brief What one of Embree's geometries holds: the triangles from a number on. */
struct TriangleRange {
  const Triangles* triangles{nullptr};
  std::uint32_t first{0};
};

/** \brief A place on a triangle: its weights of the second and the third corner. */
struct Barycentric {
  double u{0}, v{0};
};

inline Eigen::Vector3d placeOn(const Triangle& t, const Barycentric& at) {
  const Eigen::Vector3d a = t[0].cast<double>();
  return a + at.u * (t[1].cast<double>() - a) + at.v * (t[2].cast<double>() - a);
}

/** \brief A ray that lets nothing through between triangles that share an edge (Woop, Benthin and Wald, Watertight Ray/Triangle
 *  Intersection, JCGT 2013): corners are projected along it, each by itself, and of an edge's two triangles one finds the negative
 *  of what the other finds, to the bit. What lies on an edge belongs to both. */
class WatertightRay {
 public:
  WatertightRay(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction) {
    direction.cwiseAbs().maxCoeff(&z_);
    x_ = (z_ + 1) % 3;
    y_ = (z_ + 2) % 3;
    for (int axis = 0; axis < 3; ++axis) {
      origin_[axis] = static_cast<double>(origin[axis]);
      direction_[axis] = static_cast<double>(direction[axis]);
    }
    per_z_ = 1 / direction_[z_];
    slope_x_ = direction_[x_] * per_z_;
    slope_y_ = direction_[y_] * per_z_;
  }

  double along(int axis, double t) const { return origin_[axis] + t * direction_[axis]; }

  /** \brief Whether the line through the ray meets a triangle, from either side; if so at t lengths of the direction. A triangle that
   *  is seen edge-on is not met: its neighbours are. */
  bool meets(const Triangle& triangle, double& t, Barycentric& at) const {
    const Projected a = project(triangle[0]), b = project(triangle[1]), c = project(triangle[2]);
    const double u = c.x * b.y - c.y * b.x, v = a.x * c.y - a.y * c.x;
    if ((u < 0 && v > 0) || (u > 0 && v < 0)) return false;
    const double w = b.x * a.y - b.y * a.x;
    if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return false;
    const double sum = u + v + w;
    if (!(std::fabs(sum) > 0)) return false;
    const double per_sum = 1 / sum;
    t = (u * a.z + v * b.z + w * c.z) * per_sum * per_z_;
    at = {v * per_sum, w * per_sum};
    return true;
  }

 private:
  struct Projected {
    double x, y, z;
  };
  Projected project(const Eigen::Vector3f& p) const {
    const double z = static_cast<double>(p[z_]) - origin_[z_];
    return {(static_cast<double>(p[x_]) - origin_[x_]) - slope_x_ * z,
            (static_cast<double>(p[y_]) - origin_[y_]) - slope_y_ * z, z};
  }

  int x_, y_, z_{0};
  double origin_[3], direction_[3];
  double per_z_, slope_x_, slope_y_;
};

/** \brief The point of a triangle nearest to p. */
inline Barycentric nearestOnTriangle(const Eigen::Vector3d& p, const Triangle& triangle) {
  // The point lies nearest to a corner, an edge or the face, told apart by the signs of six dot products (Ericson,
  // Real-Time Collision Detection, section 5.1.5).
  const Eigen::Vector3d a = triangle[0].cast<double>(), b = triangle[1].cast<double>(), c = triangle[2].cast<double>();
  const Eigen::Vector3d ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap), d3 = ab.dot(bp), d4 = ac.dot(bp), d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d1 <= 0 && d2 <= 0) return {0, 0};
  if (d3 >= 0 && d4 <= d3) return {1, 0};
  if (d6 >= 0 && d5 <= d6) return {0, 1};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 > d3) return {d1 / (d1 - d3), 0};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0 && d2 > d6) return {0, d2 / (d2 - d6)};
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0 && (d4 - d3) + (d5 - d6) > 0) {
    const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {1 - w, w};
  }
  const double sum = va + vb + vc;
  return sum > 0 ? Barycentric{vb / sum, vc / sum} : Barycentric{0, 0};
}

/** \brief How much of the surface around one of its points lies in a triangle, radians: all of it inside, half of it on an edge, the
 *  angle there at a corner. Within a reach, metres, a point counts as on an edge or a corner. */
double angleAround(const Eigen::Vector3d& point, const Triangle& triangle, double reach);

}  // namespace fuse_flow::simulation
