#pragma once

#include "simulation/people/person_body.h"

#include <vector>

namespace fuse_flow::simulation {

/** \brief A person who walks a figure of eight around the origin at 1 m/s for ever, to the left and to the right in turn. */
class PersonWalk {
 public:
  /** \brief The path goes to ±half_length along x and ±half_width along y, metres; phase: where on it time 0 is, [0, 1). */
  PersonWalk(double half_length, double half_width, double phase);

  Pose pose(double time) const;

 private:
  /** \brief A place on the path: x forward, z up, on the floor. */
  Eigen::Isometry3d onPath(double distance) const;
  Eigen::Isometry3d foot(double walked, double side) const;

  double half_length_;
  double half_width_;
  double start_;
  std::vector<double> length_to_;  // along the path, at equal steps of its parameter
};

}  // namespace fuse_flow::simulation
