#include "float_file.h"

/** \brief Depth in NumPy's format, whose header is up to 4 KiB of text, matched by regular expressions. */
FUSE_FLOW_FUZZ_TARGET(npy, 1 << 20, 8, 1000) { fuse_flow_fuzz::readFloatFile("depth.npy", input); }
