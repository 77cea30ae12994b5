#include "../../good_frame.h"
#include "../../scratch.h"

/** \brief A bag of ROS 1. bzip2 makes up to 20 KiB of a byte. */
FUSE_FLOW_FUZZ_TARGET(rosbag, 8 << 20, 65536, 100) {
  fuse_flow::io::RecordingOptions options;
  options.without_poses = true;
  fuse_flow_fuzz::readRecording({fuse_flow_fuzz::scratchFile("rig.bag", input)}, options);
}
