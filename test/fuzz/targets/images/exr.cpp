#include "float_file.h"

#ifdef FUSE_FLOW_WITH_OPENEXR
/** \brief Depth in OpenEXR, which takes memory for the lines of a block and for a table of them. */
FUSE_FLOW_FUZZ_TARGET(exr, 4 << 20, 64, 300) { fuse_flow_fuzz::readFloatFile("depth.exr", input); }
#endif
