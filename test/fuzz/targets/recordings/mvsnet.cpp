#include "folder.h"

/** \brief MVSNet's folders: photographs, and depth that was estimated of them. */
FUSE_FLOW_FUZZ_TARGET(mvsnet, fuse_flow_fuzz::kOfFolder, fuse_flow_fuzz::kOfFolderByte, 200) {
  fuse_flow_fuzz::readFolder(fuse_flow_fuzz::bundles::mvsnet, input);
}
