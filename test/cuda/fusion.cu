// Compiled only. The tools have the frame pipeline for our own point type, and the classes that find poses.
#include <fuse_flow/gpu/adaptive_hash_fusion.h>
#include <fuse_flow/gpu/confidence_estimation.h>
#include <fuse_flow/gpu/depth_backprojection.h>
#include <fuse_flow/gpu/fuse_flow.h>
#include <fuse_flow/gpu/multi_view_consistency.h>
#include <fuse_flow/point_types.h>

template class fuse_flow::FuseFlow<pcl::PointXYZRGBNormal, fuse_flow::device::Thrust>;
template class fuse_flow::ConfidenceEstimation<fuse_flow::PointFused, fuse_flow::device::Thrust>;
template class fuse_flow::DepthBackprojection<fuse_flow::PointFused, fuse_flow::device::Thrust>;
template class fuse_flow::MultiViewConsistency<fuse_flow::PointFused, fuse_flow::device::Thrust>;
template class fuse_flow::AdaptiveHashFusion<fuse_flow::PointFused, fuse_flow::device::Thrust>;

// The host's classes in a CUDA source, for a point that has nothing but a position and one that has all.
template class fuse_flow::FuseFlow<pcl::PointXYZ, fuse_flow::device::Host>;
template class fuse_flow::FuseFlow<fuse_flow::PointFused, fuse_flow::device::Host>;
