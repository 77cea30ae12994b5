#pragma once

#include <fuse_flow/recordings/error.h>

#include <pcl/PCLPointCloud2.h>
#include <pcl/console/print.h>

#include <Eigen/Geometry>

#include <string>

namespace fuse_flow::io {

/** \brief Where the sensor of a cloud stood; PLY does not carry it. */
struct SensorPose {
  Eigen::Vector4f origin{Eigen::Vector4f::Zero()};
  Eigen::Quaternionf orientation{Eigen::Quaternionf::Identity()};
};

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

/** \brief Reads a PCD of any kind as PCL does, but takes memory for no more than the file holds, and ends where the disk does. Throws
 *  InputError. \param path a file, not a pipe */
SensorPose readPcd(const std::string& path, pcl::PCLPointCloud2& cloud);

/** \brief What to make of a file without points. */
enum class EmptyCloud { Refused, Accepted };

/** \brief Of a cloud as PCL has read it: double fields become float. Throws InputError if it is cut short, has no x, y, z or, unless
 *  that is accepted, no points. \param path what messages call it */
void checkCloud(const std::string& path, pcl::PCLPointCloud2& cloud, EmptyCloud empty = EmptyCloud::Refused);

}  // namespace fuse_flow::io
