// In place of open3d_methods.cpp where there is no Open3D.

#include "evaluation/tables/open3d_methods.h"

namespace fuse_flow::tables {

std::vector<Open3dPeer> open3dPeers() { return {}; }

std::unique_ptr<io::Method> makeOpen3dMethod(const std::string&, const io::MethodOptions&) { return nullptr; }

}  // namespace fuse_flow::tables
