#include "folder.h"

/** \brief 7-Scenes: one camera that moves, whose first image acts as a rig. */
FUSE_FLOW_FUZZ_TARGET(seven_scenes, fuse_flow_fuzz::kOfFolder, fuse_flow_fuzz::kOfFolderByte, 200) {
  fuse_flow::io::RecordingOptions options;
  options.views = "0";
  fuse_flow_fuzz::readFolder(fuse_flow_fuzz::bundles::seven_scenes, input, options);
}
