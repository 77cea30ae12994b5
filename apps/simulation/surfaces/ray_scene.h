#pragma once

#include "simulation/surfaces/mesh.h"

#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace fuse_flow::simulation {

/** \brief A point of a surface. */
struct SurfacePoint {
  Eigen::Vector3f position{Eigen::Vector3f::Zero()};
  /** \brief Unit; of the triangle, or interpolated where the mesh has normals. */
  Eigen::Vector3f normal{Eigen::Vector3f::Zero()};
  Eigen::Vector3f rest{Eigen::Vector3f::Zero()};
  /** \brief m/s; zero where the mesh has none. */
  Eigen::Vector3f velocity{Eigen::Vector3f::Zero()};
  /** \brief Number among the fixed objects, then the moving ones. */
  std::uint32_t object{0};
};

/** \brief Where a ray first meets a surface. */
struct RayHit : SurfacePoint {
  /** \brief In lengths of the ray's direction; infinite: nowhere. */
  float t{std::numeric_limits<float>::infinity()};
  explicit operator bool() const { return t < std::numeric_limits<float>::infinity(); }
};

/** \brief The point of a scene's surfaces that is nearest to a place. */
struct NearestHit : RayHit {
  /** \brief Distance to the surface, metres, as t is; negative where the place lies behind the surface, inside a closed mesh. */
  float signed_distance{std::numeric_limits<float>::infinity()};
};

/** \brief Ray casting and nearest points in a scene. Queries may run on many threads at once.
 *
 *  Embree tells which triangles come into question; whether and where a ray meets one of them, and which is the nearest, is
 *  decided by arithmetic of our own (ray_triangle.h). Of triangles that are met at the same place the first counts, by object and
 *  by number in its mesh. So the answers are the same, to the bit, on every processor, with every version of Embree and in every
 *  order in which it visits triangles; and no ray passes between triangles that share an edge. Rays are to start within ten times the
 *  largest coordinate of the scene: farther off, Embree's own rounding may leave out what they would meet. */
class RayScene {
 public:
  /** \brief \param embree Embree's configuration, such as "isa=avx,threads=1"; changes no answer. Throws std::runtime_error if
   *  Embree cannot be started with it. */
  explicit RayScene(const std::string& embree = "");
  ~RayScene();
  RayScene(RayScene&&) noexcept;
  RayScene& operator=(RayScene&&) noexcept;

  /** \brief Replaces what never moves. */
  void setFixed(const std::vector<Object>& objects);
  /** \brief Replaces what moves. */
  void setMoving(const std::vector<Object>& objects);
  /** \brief The same, while it moves: the objects at up to 129 times (Embree's limit), evenly spread over an interval, of which 0 is the first moment
   *  and 1 the last. At each time the same objects with the same triangles; in between vertices move on straight lines.
   *  \throws std::invalid_argument if they are others, or at more times; nothing has changed then */
  void setMotion(std::vector<std::vector<Object>> steps);

  /** \brief The first surface on a ray, from either side of it, at a moment of the motion, which is limited to [0, 1]; without a motion it
   *  does not matter. */
  RayHit intersect(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, float moment = 0) const;

  /** \brief Whether a surface stands between two points; within margin (metres) of either end does not count. */
  bool occluded(const Eigen::Vector3f& from, const Eigen::Vector3f& to, float margin = 1e-3f, float moment = 0) const;

  /** \brief The nearest point of any surface, at the first moment; t is its distance, infinite if none lies within radius. The normal is the mean over
   *  all triangles that touch the point, each weighted with its angle there; so is the normal that decides on which side of the
   *  surface the place lies (Bærentzen and Aanæs, Signed Distance Computation Using the Angle Weighted Pseudonormal, TVCG 2005),
   *  of flat triangles there. */
  NearestHit nearest(const Eigen::Vector3f& point, float radius = std::numeric_limits<float>::infinity()) const;

  const Object& object(std::uint32_t number) const;
  bool moving(std::uint32_t number) const;
  std::uint32_t objectCount() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace fuse_flow::simulation
