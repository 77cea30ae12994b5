#pragma once

#include "simulation/mesh.h"

#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

namespace fuse_flow::simulation {

/** \brief A point of a surface. */
struct SurfacePoint {
  Eigen::Vector3f position{Eigen::Vector3f::Zero()};
  /** \brief Unit; of the triangle, or interpolated where the mesh has normals. */
  Eigen::Vector3f normal{Eigen::Vector3f::Zero()};
  Eigen::Vector3f rest{Eigen::Vector3f::Zero()};
  /** \brief Number among the fixed objects, then the moving ones. */
  std::uint32_t object{0};
};

/** \brief Where a ray first meets a surface. */
struct RayHit : SurfacePoint {
  /** \brief In lengths of the ray's direction; infinite: nowhere. */
  float t{std::numeric_limits<float>::infinity()};
  explicit operator bool() const { return t < std::numeric_limits<float>::infinity(); }
};

/** \brief Ray casting and nearest points in a scene, by Embree. Queries may run on many threads at once. */
class RayScene {
 public:
  RayScene();
  ~RayScene();
  RayScene(RayScene&&) noexcept;
  RayScene& operator=(RayScene&&) noexcept;

  /** \brief Replaces what never moves. */
  void setFixed(const std::vector<Object>& objects);
  /** \brief Replaces what moves. */
  void setMoving(const std::vector<Object>& objects);

  /** \brief The first surface on a ray, from either side of it. */
  RayHit intersect(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction) const;

  /** \brief Whether a surface stands between two points; within margin (metres) of either end does not count. */
  bool occluded(const Eigen::Vector3f& from, const Eigen::Vector3f& to, float margin = 1e-3f) const;

  /** \brief The nearest point of any surface; t is its distance, infinite if none lies within radius. */
  RayHit nearest(const Eigen::Vector3f& point, float radius = std::numeric_limits<float>::infinity()) const;

  const Object& object(std::uint32_t number) const;
  bool moving(std::uint32_t number) const;
  std::uint32_t objectCount() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace fuse_flow::simulation
