#include "cloud_file.h"

/** \brief A cloud. PCL's reader keeps a function for each property, and each line of a header it splits. */
FUSE_FLOW_FUZZ_TARGET(ply, 1 << 20, 1024, 400) { fuse_flow_fuzz::readCloudFile("cloud.ply", input); }
