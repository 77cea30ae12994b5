#pragma once

#include "simulation/surfaces/mesh.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

namespace mesh_checks {

using Eigen::Vector3d;
using Eigen::Vector3f;
using fuse_flow::simulation::Object;
using fuse_flow::simulation::TriangleMesh;

inline Vector3d corner(const TriangleMesh& mesh, const std::array<std::uint32_t, 3>& t, std::size_t k) {
  return mesh.vertices[t[k]].cast<double>();
}

inline Vector3d areaVector(const TriangleMesh& mesh, const std::array<std::uint32_t, 3>& t) {
  const Vector3d a = corner(mesh, t, 0);
  return 0.5 * (corner(mesh, t, 1) - a).cross(corner(mesh, t, 2) - a);
}

/** \brief By the divergence theorem: positive if triangles are counter-clockwise seen from outside. */
inline double volume(const TriangleMesh& mesh) {
  double sum = 0;
  for (const auto& t : mesh.triangles) sum += corner(mesh, t, 0).dot(areaVector(mesh, t)) / 3;
  return sum;
}

inline double area(const TriangleMesh& mesh) {
  double sum = 0;
  for (const auto& t : mesh.triangles) sum += areaVector(mesh, t).norm();
  return sum;
}

/** \brief Edges that no triangle passes in the opposite direction; vertices at the same position are one. */
inline std::size_t openEdges(const std::vector<const TriangleMesh*>& meshes) {
  std::map<std::array<float, 3>, int> numbers;
  std::map<std::pair<int, int>, int> passes;
  for (const TriangleMesh* mesh : meshes) {
    std::vector<int> welded;
    for (const Vector3f& v : mesh->vertices)
      welded.push_back(
          numbers.emplace(std::array<float, 3>{v.x(), v.y(), v.z()}, static_cast<int>(numbers.size())).first->second);
    for (const auto& t : mesh->triangles)
      for (std::size_t k = 0; k < 3; ++k) {
        const int a = welded[t[k]], b = welded[t[(k + 1) % 3]];
        if (a != b) passes[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
      }
  }
  std::size_t open = 0;
  for (const auto& edge : passes) open += edge.second != 0 ? 1 : 0;
  return open;
}

/** \brief Share of the corners of triangles whose vertex normal is over 90° from the triangle's. */
inline double backwardNormals(const TriangleMesh& mesh) {
  std::size_t backward = 0;
  for (const auto& t : mesh.triangles) {
    const Vector3d normal = areaVector(mesh, t);
    for (const std::uint32_t k : t) backward += normal.dot(mesh.normals[k].cast<double>()) < 0 ? 1 : 0;
  }
  return static_cast<double>(backward) / static_cast<double>(3 * mesh.triangles.size());
}

inline bool allFinite(const TriangleMesh& mesh) {
  for (const Vector3f& v : mesh.vertices)
    if (!v.allFinite()) return false;
  for (const auto& t : mesh.triangles)
    for (const std::uint32_t k : t)
      if (k >= mesh.vertices.size()) return false;
  return true;
}

inline bool unitNormals(const TriangleMesh& mesh) {
  if (mesh.normals.size() != mesh.vertices.size()) return false;
  for (const Vector3f& n : mesh.normals)
    if (!(std::fabs(n.norm() - 1) < 1e-4f)) return false;
  return true;
}

/** \brief A square in the plane z = height, its normal up; 0.7 of the infrared light comes back. */
inline Object squareFacingUp(float half, float height) {
  Object object;
  object.name = "square";
  object.mesh.vertices = {{-half, -half, height}, {half, -half, height}, {half, half, height}, {-half, half, height}};
  object.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return object;
}

}  // namespace mesh_checks
