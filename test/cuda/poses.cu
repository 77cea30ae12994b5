// Compiled only, without the host's algebra, which another compiler compiles: see fuse_flow/precompiled.h.
#define FUSE_FLOW_PRECOMPILED
#include <fuse_flow/gpu/extrinsic_tracking.h>
#include <fuse_flow/point_types.h>

template class fuse_flow::ExtrinsicEstimation<fuse_flow::PointFused, fuse_flow::device::Thrust>;
template class fuse_flow::ExtrinsicTracking<fuse_flow::PointFused, fuse_flow::device::Thrust>;
