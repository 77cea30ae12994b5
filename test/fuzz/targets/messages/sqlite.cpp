#include "../../good_frame.h"
#include "../../scratch.h"

#ifdef FUSE_FLOW_WITH_SQLITE
/** \brief A bag of ROS 2 in SQLite, which keeps pages of the file; 3.40 also takes, and does not touch, as much as a row says that it has. */
FUSE_FLOW_FUZZ_TARGET(sqlite, 16 << 20, 1024, 100) {
  fuse_flow::io::RecordingOptions options;
  options.without_poses = true;
  fuse_flow_fuzz::allowMemory(std::size_t{1} << 30);
  fuse_flow_fuzz::readRecording({fuse_flow_fuzz::scratchFile("rig.db3", input)}, options);
}
#endif
