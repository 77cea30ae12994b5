#include "folder.h"

/** \brief Redwood and Open3D: one camera that moves, whose second image acts as a rig. */
FUSE_FLOW_FUZZ_TARGET(redwood, fuse_flow_fuzz::kOfFolder, fuse_flow_fuzz::kOfFolderByte, 200) {
  fuse_flow::io::RecordingOptions options;
  options.views = "1";
  fuse_flow_fuzz::readFolder(fuse_flow_fuzz::bundles::redwood, input, options);
}
