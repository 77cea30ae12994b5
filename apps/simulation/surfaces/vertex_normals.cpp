#include "simulation/surfaces/vertex_normals.h"

#include "simulation/portable_math.h"

#include <algorithm>

namespace fuse_flow::simulation {

using Eigen::Vector3f;

std::vector<Vector3f> vertexNormals(const std::vector<Vector3f>& vertices,
                                    const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  std::vector<Vector3f> normals(vertices.size(), Vector3f::Zero());
  for (const auto& t : triangles) {
    const Vector3f normal = (vertices[t[1]] - vertices[t[0]]).cross(vertices[t[2]] - vertices[t[0]]).normalized();
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3f a = (vertices[t[(k + 1) % 3]] - vertices[t[k]]).normalized();
      const Vector3f b = (vertices[t[(k + 2) % 3]] - vertices[t[k]]).normalized();
      normals[t[k]] += portable::acos(std::clamp(a.dot(b), -1.0f, 1.0f)) * normal;
    }
  }
  for (Vector3f& n : normals) n.normalize();
  return normals;
}

}  // namespace fuse_flow::simulation
