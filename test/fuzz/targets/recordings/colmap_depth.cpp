#include "../images/float_file.h"

/** \brief A depth map of COLMAP. */
FUSE_FLOW_FUZZ_TARGET(colmap_depth, 1 << 18, 8, 1000) { fuse_flow_fuzz::readFloatFile("depth.bin", input); }
