// The frame pipeline, compiled once. It is no template, so that any point type goes with it: see fuse_flow/precompiled.h.
#define FUSE_FLOW_PRECOMPILING
#include <fuse_flow/fuse_flow.h>
