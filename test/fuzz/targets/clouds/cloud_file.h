#pragma once

#include "../../fuzz_target.h"
#include "../../good_frame.h"
#include "../../scratch.h"

#include "clouds/cloud_io.h"
#include "methods/point_fused_normal.h"

#include <fuse_flow/recordings/error.h>

namespace fuse_flow_fuzz {

/** \brief As fields, and as points. \returns its path */
inline std::string readCloudFile(const char* name, std::string_view input) {
  using namespace fuse_flow;
  const std::string path = scratchFile(name, input);
  accepts<io::InputError>([&] {
    pcl::PCLPointCloud2 cloud;
    io::readCloud(path, cloud, io::EmptyCloud::Accepted);
    require(cloud.data.size() >= std::size_t{cloud.width} * cloud.height * cloud.point_step, "fewer bytes than points");
  });
  accepts<io::InputError>([&] {
    pcl::PointCloud<io::PointFusedNormal> cloud;
    io::readCloud(path, cloud);
    require(!cloud.empty(), "no points, which is refused");
  });
  return path;
}

}  // namespace fuse_flow_fuzz
