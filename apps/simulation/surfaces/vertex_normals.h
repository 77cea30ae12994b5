#pragma once

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <vector>

namespace fuse_flow::simulation {

/** \brief Means of the normals of the triangles around each vertex, weighted with the angles there. */
std::vector<Eigen::Vector3f> vertexNormals(const std::vector<Eigen::Vector3f>& vertices,
                                           const std::vector<std::array<std::uint32_t, 3>>& triangles);

}  // namespace fuse_flow::simulation
