// What precompiled.h and test_fuse_flow_point_types.cpp declare to be compiled elsewhere.
#include "conformance_points.h"

#include <fuse_flow/fuse_flow.h>

template class fuse_flow::FuseFlow<fuse_flow::PointFused>;
template class fuse_flow::FuseFlow<pcl::PointXYZRGBNormal>;
template class fuse_flow::FuseFlow<pcl::PointXYZ>;
template class fuse_flow::FuseFlow<conformance::OddPoint>;
#if !defined(FUSE_FLOW_TEST_FEW_POINT_TYPES)
template class fuse_flow::FuseFlow<pcl::PointXYZI>;
template class fuse_flow::FuseFlow<pcl::PointXYZRGB>;
template class fuse_flow::FuseFlow<pcl::PointSurfel>;
#endif
