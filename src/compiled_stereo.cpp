// Multi-view stereo on the CPU, compiled once: see fuse_flow/precompiled.h.
#define FUSE_FLOW_PRECOMPILING
#include <fuse_flow/stereo/epipolar_errors.h>
#include <fuse_flow/stereo/multi_view_stereo.h>
