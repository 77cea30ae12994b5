#pragma once

#include "io/error.h"

#include <pcl/PCLPointCloud2.h>
#include <pcl/console/print.h>
#include <pcl/conversions.h>
#include <pcl/point_cloud.h>

#include <string>

namespace fuse_flow::io {

/** \brief Where the sensor of a cloud stood; PLY does not carry it. */
struct SensorPose {
  Eigen::Vector4f origin{Eigen::Vector4f::Zero()};
  Eigen::Quaternionf orientation{Eigen::Quaternionf::Identity()};
};

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

/** \brief What to make of a file without points. */
enum class EmptyCloud { Refused, Accepted };

/** \brief Reads a PLY or PCD, chosen by the extension; double fields become float. Throws InputError if it is missing,
 *  damaged, without x, y, z, of another type or, unless that is accepted, without points. */
SensorPose readCloud(const std::string& path, pcl::PCLPointCloud2& cloud, EmptyCloud empty = EmptyCloud::Refused);

/** \brief Keeps PCL's readers from printing while it lives: what matters is thrown. */
class SilencePcl {
 public:
  SilencePcl() : level_(pcl::console::getVerbosityLevel()) { pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS); }
  ~SilencePcl() { pcl::console::setVerbosityLevel(level_); }
  SilencePcl(const SilencePcl&) = delete;
  SilencePcl& operator=(const SilencePcl&) = delete;

 private:
  pcl::console::VERBOSITY_LEVEL level_;
};

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
