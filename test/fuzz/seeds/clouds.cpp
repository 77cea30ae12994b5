#include "../scratch.h"
#include "../seeds.h"

#include "clouds/cloud_io.h"
#include "methods/point_fused_normal.h"
#include "recordings/files/file_io.h"

#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>
#include <pcl/point_types.h>

namespace fuse_flow_fuzz {
namespace {

/** \brief As a camera of 8 × 6 pixels sees a wall. */
pcl::PointCloud<pcl::PointXYZRGB> organised() {
  pcl::PointCloud<pcl::PointXYZRGB> cloud(8, 6);
  for (int v = 0; v < 6; ++v)
    for (int u = 0; u < 8; ++u) {
      pcl::PointXYZRGB& point = cloud(u, v);
      point.z = 1 + 0.01f * static_cast<float>(u);
      point.x = point.z * (static_cast<float>(u) - 3.5f) / 10;
      point.y = point.z * (static_cast<float>(v) - 2.5f) / 10;
      point.r = static_cast<std::uint8_t>(20 * u);
    }
  return cloud;
}

pcl::PointCloud<fuse_flow::io::PointFusedNormal> fused() {
  pcl::PointCloud<fuse_flow::io::PointFusedNormal> cloud(5, 1);
  for (std::size_t k = 0; k < cloud.size(); ++k) cloud[k].x = cloud[k].normal_z = static_cast<float>(k);
  return cloud;
}

std::string writtenCloud(const char* name, const std::function<void(const std::string&)>& write) {
  const std::string path = scratchFile(name, "");
  write(path);
  return fuse_flow::io::readFile(path);
}

}  // namespace

void addCloudSeeds(Seeds& seeds) {
  seeds["pcd"] = {
      writtenCloud("seed.pcd", [](const std::string& path) { pcl::io::savePCDFileASCII(path, organised()); }),
      writtenCloud("seed.pcd", [](const std::string& path) { pcl::io::savePCDFileBinary(path, organised()); }),
      writtenCloud("seed.pcd",
                   [](const std::string& path) { pcl::io::savePCDFileBinaryCompressed(path, organised()); }),
      writtenCloud("seed.pcd", [](const std::string& path) { fuse_flow::io::writeCloud(path, fused()); }),
      "VERSION 0.7\nFIELDS x y z _ intensity\nSIZE 8 8 8 1 4\nTYPE F F F U F\nCOUNT 1 1 1 4 1\nWIDTH 2\nHEIGHT "
      "1\nPOINTS 2\nDATA "
      "ascii\n1 2 3 0 0 0 0 4\nnan nan nan 1 2 3 4 5\n"};
  seeds["ply"] = {
      writtenCloud("seed.ply", [](const std::string& path) { fuse_flow::io::writeCloud(path, fused()); }),
      writtenCloud("seed.ply", [](const std::string& path) { pcl::io::savePLYFileBinary(path, organised()); }),
      "ply\nformat ascii 1.0\ncomment no\nelement vertex 3\nproperty float x\nproperty double y\nproperty float "
      "z\nproperty uchar "
      "red\nproperty uchar green\nproperty uchar blue\nelement face 1\nproperty list uchar int "
      "vertex_indices\nend_header\n0 0 0 1 2 "
      "3\n1 0 0 4 5 6\n0 1 0 7 8 9\n3 0 1 2\n",
      "ply\nformat binary_big_endian 1.0\nobj_info num_cols 2\nobj_info num_rows 1\nelement vertex 2\nproperty float "
      "x\nproperty float "
      "y\nproperty float z\nend_header\n" +
          std::string(24, '\x3f')};
  seeds["livescan"] = {"n_points= 2\nframe_timestamp= 17\n" + std::string(20, '\x10') +
                       "\nn_points= 1\r\nframe_timestamp= 18\r\n" + std::string(10, '\x20') + "\n"};
}

}  // namespace fuse_flow_fuzz
