#pragma once

#include "methods/method.h"

#include <string>
#include <vector>

namespace fuse_flow::tables {

/** \brief A peer from Open3D: its name for the tables, and for makeOpen3dMethod(). */
struct Open3dPeer {
  std::string name;
  std::string method;
};

/** \brief None where the tables are built without Open3D. */
std::vector<Open3dPeer> open3dPeers();

/** \brief MethodOptions::leaf_size is the side of a voxel. Their times leave out what converting between the libraries takes.
 *  \return null if the name is none of open3dPeers() */
std::unique_ptr<io::Method> makeOpen3dMethod(const std::string& name, const io::MethodOptions& options);

}  // namespace fuse_flow::tables
