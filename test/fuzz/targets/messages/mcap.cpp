#include "../../good_frame.h"
#include "../../scratch.h"

/** \brief A bag of ROS 2 in MCAP. Zstandard makes up to 32 KiB of a byte. */
FUSE_FLOW_FUZZ_TARGET(mcap, 8 << 20, 65536, 300) {
  fuse_flow::io::RecordingOptions options;
  options.without_poses = true;
  fuse_flow_fuzz::readRecording({fuse_flow_fuzz::scratchFile("rig.mcap", input)}, options);
}
