// What precompiled.h declares to be compiled elsewhere.
#include <fuse_flow/fuse_flow.h>
#include <fuse_flow/point_types.h>

#include <pcl/point_types.h>

template class fuse_flow::FuseFlow<fuse_flow::PointFused>;
template class fuse_flow::FuseFlow<pcl::PointXYZRGBNormal>;
