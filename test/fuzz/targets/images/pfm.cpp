#include "float_file.h"

/** \brief Depth that a network estimated, as a Portable Float Map. The file is held once as it is and once as float; the header is matched by a regular
 *  expression. */
FUSE_FLOW_FUZZ_TARGET(pfm, 1 << 18, 8, 1000) { fuse_flow_fuzz::readFloatFile("depth.pfm", input); }
