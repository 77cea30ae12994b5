#include "ros_message.h"

#ifdef FUSE_FLOW_WITH_FASTCDR
/** \brief The same messages of ROS 2, in CDR. */
FUSE_FLOW_FUZZ_TARGET(cdr_message, 1 << 19, 64, 2000) { fuse_flow_fuzz::readMessage(fuse_flow::io::Wire::Cdr, input); }
#endif
