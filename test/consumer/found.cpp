// That the library is found with what it needs: what consumer.cpp does with it does not depend on how it was found.
#include <fuse_flow/camera.h>
#include <fuse_flow/point_types.h>

#include <pcl/conversions.h>

#ifdef HAS_RECORDINGS
#include <fuse_flow/recordings/error.h>
#include <fuse_flow/recordings/rig_json.h>
#endif

#ifndef __NO_MATH_ERRNO__
#error "the library's options for the compiler are missing"
#endif

int main() {
#ifdef HAS_RECORDINGS
  try {
    fuse_flow::io::readRigJson("/");
    return 1;
  } catch (const fuse_flow::io::InputError&) {
  }
#endif
  fuse_flow::Camera camera;
  camera.intrinsics = {64, 48, 60.0f, 60.0f, 31.5f, 23.5f, {}};
  fuse_flow::checkCamera(camera);
  pcl::PCLPointCloud2 cloud;
  pcl::toPCLPointCloud2(pcl::PointCloud<fuse_flow::PointFused>(3, 1), cloud);
  cloud += pcl::PCLPointCloud2(cloud);  // is in libpcl_common
  return cloud.width * cloud.height == 6 ? 0 : 1;
}
