#pragma once

#include "io/cloud_io.h"

#include <string>

namespace fuse_flow::io {

/** \brief Reads a PCD of any kind as PCL does, but takes memory for no more than the file holds, and ends where the disk does. Throws
 *  InputError. \param path a file, not a pipe */
SensorPose readPcd(const std::string& path, pcl::PCLPointCloud2& cloud);

}  // namespace fuse_flow::io
