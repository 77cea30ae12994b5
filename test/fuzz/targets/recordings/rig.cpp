#include "folder.h"

/** \brief Two cameras, with times. */
FUSE_FLOW_FUZZ_TARGET(rig, fuse_flow_fuzz::kOfFolder, fuse_flow_fuzz::kOfFolderByte, 200) {
  fuse_flow_fuzz::readFolder(fuse_flow_fuzz::bundles::rig, input);
}
