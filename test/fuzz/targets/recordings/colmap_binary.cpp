#include "folder.h"

/** \brief COLMAP's workspace with its model in binary files. */
FUSE_FLOW_FUZZ_TARGET(colmap_binary, fuse_flow_fuzz::kOfFolder, fuse_flow_fuzz::kOfFolderByte, 200) {
  fuse_flow_fuzz::readFolder(fuse_flow_fuzz::bundles::colmap_binary, input);
}
