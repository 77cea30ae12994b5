// The classes that find poses on the CPU, and with them the host's algebra of the GPU's: compiled by a compiler that vectorises it.
#define FUSE_FLOW_PRECOMPILING
#include <fuse_flow/calibration/extrinsic_estimation.h>
#include <fuse_flow/calibration/extrinsic_tracking.h>
#include <fuse_flow/point_types.h>

template class fuse_flow::ExtrinsicEstimation<fuse_flow::PointFused>;
template class fuse_flow::ExtrinsicTracking<fuse_flow::PointFused>;
