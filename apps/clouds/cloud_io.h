#pragma once

#include "recordings/files/pcd_file.h"

#include <pcl/PCLPointCloud2.h>
#include <pcl/conversions.h>
#include <pcl/point_cloud.h>

#include <string>

namespace fuse_flow::io {

/** \brief Writes a binary PLY or PCD, chosen by the extension. The file appears complete or not at all; see
 *  writeFile(). PLY leaves out points that are not finite, and names normals and colours as other programs expect.
 *  Throws OutputError. */
void writeCloud(const std::string& path, const pcl::PCLPointCloud2& cloud, const SensorPose& pose = {});

template <typename PointT>
void writeCloud(const std::string& path, const pcl::PointCloud<PointT>& cloud) {
  pcl::PCLPointCloud2 blob;
  pcl::toPCLPointCloud2(cloud, blob);
  writeCloud(path, blob, {cloud.sensor_origin_, cloud.sensor_orientation_});
}

/** \brief Reads a PLY or PCD, chosen by the extension; double fields become float. Throws InputError if it is missing,
 *  damaged, without x, y, z, of another type or, unless that is accepted, without points. */
SensorPose readCloud(const std::string& path, pcl::PCLPointCloud2& cloud, EmptyCloud empty = EmptyCloud::Refused);

/** \brief As above; fields that PointT has and the file lacks keep their defaults. */
template <typename PointT>
void readCloud(const std::string& path, pcl::PointCloud<PointT>& cloud) {
  pcl::PCLPointCloud2 blob;
  const SensorPose pose = readCloud(path, blob);
  const SilencePcl silence;
  pcl::fromPCLPointCloud2(blob, cloud);
  cloud.sensor_origin_ = pose.origin;
  cloud.sensor_orientation_ = pose.orientation;
}

}  // namespace fuse_flow::io
