#include "folder.h"

/** \brief TUM RGB-D: one camera that moves, whose first image acts as a rig. */
FUSE_FLOW_FUZZ_TARGET(tum, fuse_flow_fuzz::kOfFolder, fuse_flow_fuzz::kOfFolderByte, 200) {
  fuse_flow::io::RecordingOptions options;
  options.views = "0";
  fuse_flow_fuzz::readFolder(fuse_flow_fuzz::bundles::tum, input, options);
}
