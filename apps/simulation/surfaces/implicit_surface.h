#pragma once

#include "simulation/surfaces/mesh.h"

#include <Eigen/Geometry>

#include <functional>

namespace fuse_flow::simulation {

/** \brief Negative inside of a body, positive outside, smooth; about the distance from its surface in metres: it changes
 *  by at most 2 per metre. */
using ImplicitBody = std::function<double(const Eigen::Vector3d&)>;

/** \brief The closed surface of a body, vertices exactly on it, normals along its gradient. The body must lie within bounds
 *  and be thicker than two voxels; metres. */
TriangleMesh polygonise(const ImplicitBody& body, const Eigen::AlignedBox3d& bounds, double voxel);

/** \brief Unit; outward. */
Eigen::Vector3d gradientDirection(const ImplicitBody& body, const Eigen::Vector3d& p);

/** \brief A capsule between two points whose radius changes from one to the other. */
double capsuleDistance(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b, double radius_a,
                       double radius_b);

double ellipsoidDistance(const Eigen::Vector3d& p, const Eigen::Vector3d& centre, const Eigen::Vector3d& half_axes);

/** \brief The union of two bodies, with a fillet that reaches as far as they are both nearer than blend, metres (the
 *  quadratic polynomial smooth minimum). */
double smoothUnion(double a, double b, double blend);

}  // namespace fuse_flow::simulation
