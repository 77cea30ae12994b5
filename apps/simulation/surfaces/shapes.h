#pragma once

#include "simulation/surfaces/mesh.h"

#include <Eigen/Geometry>

#include <functional>
#include <vector>

/** \file
 *  \brief Closed meshes of simple solids, with normals: vertices are split at creases, so that faces are flat and round
 *  parts smooth. Round parts are so fine that no chord lies over 0.1 mm from the surface. */

namespace fuse_flow::simulation {

/** \brief Around the origin; size: whole sides. */
TriangleMesh box(const Eigen::Vector3f& size);

/** \brief Around the origin, edges and corners rounded. */
TriangleMesh roundedBox(const Eigen::Vector3f& size, float radius);

TriangleMesh sphere(float radius);
TriangleMesh ellipsoid(const Eigen::Vector3f& half_axes);

/** \brief From z = 0 up to height, radii at the bottom and at the top; a top radius of 0 makes a cone. */
TriangleMesh cylinder(float bottom_radius, float top_radius, float height);

/** \brief Smooth pieces of a profile (radius, z), each from the last one's end; between them are creases. */
using Profile = std::vector<std::vector<Eigen::Vector2f>>;

/** \brief A surface of revolution about z. The profile runs from the axis at the bottom, outside on its right, back to the
 *  axis. */
TriangleMesh lathe(const Profile& profile);

/** \brief Points of an arc of a profile, angles from the radius axis towards z, radians. */
std::vector<Eigen::Vector2f> arc(const Eigen::Vector2f& centre, float radius, float from, float to);

/** \brief A round rod along a path, flat at its ends. */
TriangleMesh tube(const std::vector<Eigen::Vector3f>& path, float radius);
TriangleMesh rod(const Eigen::Vector3f& from, const Eigen::Vector3f& to, float radius);

/** \brief A ring around z in the plane z = 0. */
TriangleMesh torus(float ring_radius, float tube_radius);

/** \brief A polygon in the plane z = 0, counter-clockwise and seen whole from the origin, raised to height. */
TriangleMesh extrude(const std::vector<Eigen::Vector2f>& polygon, float height);

/** \brief A triangle mesh in another place. */
TriangleMesh moved(TriangleMesh mesh, const Eigen::Isometry3f& T);
TriangleMesh moved(TriangleMesh mesh, const Eigen::Vector3f& by);

/** \brief A triangle mesh under a smooth map of space that keeps right hands right; finer than the map's bends. */
TriangleMesh bent(TriangleMesh mesh, const std::function<Eigen::Vector3f(const Eigen::Vector3f&)>& map);

/** \brief Both meshes in one. */
void append(TriangleMesh& mesh, const TriangleMesh& more);

/** \brief Turned about z by an angle in radians, then moved. */
Eigen::Isometry3f placed(const Eigen::Vector3f& at, float angle);

}  // namespace fuse_flow::simulation
