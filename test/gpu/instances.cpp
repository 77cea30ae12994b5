// What device_comparison.h declares to be compiled elsewhere.
#include <fuse_flow/gpu/fuse_flow.h>
#include <fuse_flow/point_types.h>

template class fuse_flow::FuseFlow<fuse_flow::PointFused>;
template class fuse_flow::FuseFlow<fuse_flow::PointFused, fuse_flow::device::Thrust>;
