// The classes that find poses, and what cameras measure wrong, compiled once for two point types: see fuse_flow/precompiled.h.
#define FUSE_FLOW_PRECOMPILING
#include <fuse_flow/calibration/coarse_alignment.h>
#include <fuse_flow/calibration/depth_correction_estimation.h>
#include <fuse_flow/calibration/extrinsic_estimation.h>
#include <fuse_flow/calibration/extrinsic_tracking.h>
#include <fuse_flow/calibration/pose_filter.h>
#include <fuse_flow/point_types.h>

#include <pcl/point_types.h>

template class fuse_flow::ExtrinsicEstimation<fuse_flow::PointFused>;
template class fuse_flow::ExtrinsicEstimation<pcl::PointXYZ>;
template class fuse_flow::ExtrinsicTracking<fuse_flow::PointFused>;
template class fuse_flow::ExtrinsicTracking<pcl::PointXYZ>;
