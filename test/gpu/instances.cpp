// What device_comparison.h and pose_comparison.h declare to be compiled elsewhere.
#include <fuse_flow/gpu/calibration/extrinsic_estimation.h>
#include <fuse_flow/gpu/fuse_flow.h>
#include <fuse_flow/point_types.h>

#include <pcl/point_types.h>

template class fuse_flow::FuseFlow<fuse_flow::PointFused>;
template class fuse_flow::FuseFlow<fuse_flow::PointFused, fuse_flow::device::Thrust>;
template class fuse_flow::ExtrinsicEstimation<pcl::PointXYZ, fuse_flow::device::Thrust>;
