#pragma once

#include <fuse_flow/depth_view.h>

#include <Eigen/Core>

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

namespace fuse_flow::io {

/** \brief Where a ray first meets a surface. */
struct Hit {
  /** \brief In lengths of the ray's direction. */
  double t{0};
  /** \brief Unit, world frame, towards the ray's origin. */
  Eigen::Vector3d normal{Eigen::Vector3d::Zero()};
};

/** \brief Two colours in a chequered pattern. */
struct Paint {
  Rgb8 first;
  Rgb8 second;
  /** \brief Side of a square, metres. */
  double size{0.1};
};

/** \brief A surface with an exact ray intersection and an exact distance. */
class Shape {
 public:
  explicit Shape(const Paint& paint) : paint_(paint) {}
  virtual ~Shape() = default;
  virtual std::optional<Hit> intersect(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const = 0;
  /** \brief From a point in the world to the surface, metres, not negative. */
  virtual double distance(const Eigen::Vector3d& p_W) const = 0;
  Rgb8 colorAt(const Eigen::Vector3d& p_W) const;

 private:
  Paint paint_;
};

/** \brief A room corner with a table box, a ball, a column and a ball that rolls on the floor. */
class DemoScene {
 public:
  explicit DemoScene(std::size_t frame);

  struct SceneHit : Hit {
    const Shape* shape{nullptr};
  };
  std::optional<SceneHit> trace(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;
  /** \brief Whether nothing stands between two points. */
  bool sees(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const;
  double distance(const Eigen::Vector3d& p_W) const;

 private:
  std::vector<std::unique_ptr<Shape>> shapes_;
};

}  // namespace fuse_flow::io
