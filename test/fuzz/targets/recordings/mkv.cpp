#include "../../good_frame.h"
#include "../../scratch.h"

#ifdef FUSE_FLOW_WITH_LIBAV
/** \brief A file of an Azure Kinect, which libavformat reads: it takes buffers of its own. A packet is copied while it waits. */
FUSE_FLOW_FUZZ_TARGET(mkv, 16 << 20, 1024, 50) {
  fuse_flow_fuzz::readRecording({fuse_flow_fuzz::scratchFile("left.mkv", input)});
}
#endif
