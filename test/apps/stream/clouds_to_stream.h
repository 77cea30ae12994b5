#pragma once

#include <fuse_flow/point_types.h>

#include <pcl/point_cloud.h>

#include <cmath>
#include <cstdint>
#include <random>

namespace fuse_flow::test {

/** \brief Points of a wall, x from 0 to 4 m, z from 0 to 2.5 m, every 10 mm, each off by up to 3 mm along each axis; y is 1. */
inline pcl::PointCloud<PointFusedCameras> wall(unsigned int seed = 1) {
  std::mt19937 random(seed);  // the same numbers on every machine
  const auto unit = [&] { return static_cast<double>(random()) / 4294967296.0; };
  pcl::PointCloud<PointFusedCameras> cloud;
  for (int column = 0; column < 400; ++column)
    for (int row = 0; row < 250; ++row) {
      PointFusedCameras point;
      point.x = static_cast<float>(0.01 * column + 0.006 * unit());
      point.y = static_cast<float>(1 + 0.006 * unit());
      point.z = static_cast<float>(0.01 * row + 0.006 * unit());
      point.r = static_cast<std::uint8_t>(100 + 50 * std::sin(0.05 * column));
      point.g = static_cast<std::uint8_t>(120 + random() % 8);
      point.b = static_cast<std::uint8_t>(row);
      point.confidence = static_cast<float>(unit());
      point.view_count = 1 + random() % 4;
      point.camera_mask[0] = 1u << random() % 4;
      point.camera_mask[1] = column > 200 ? 1u << 3 : 0;
      cloud.push_back(point);
    }
  return cloud;
}

}  // namespace fuse_flow::test
