#include "folder.h"

/** \brief COLMAP's workspace with its model as text. */
FUSE_FLOW_FUZZ_TARGET(colmap, fuse_flow_fuzz::kOfFolder, fuse_flow_fuzz::kOfFolderByte, 200) {
  fuse_flow_fuzz::readFolder(fuse_flow_fuzz::bundles::colmap, input);
}
