#pragma once

#include <string>

namespace fuse_flow::io {

/** \brief Of a recording of which no colour is read: "no colour is read, and 40 other images are there, such as /rec/photos/1.png; colour must be
 *  …"; empty where there are none. Images whose names, or folders' names, say that they are something else do not count: depth, confidence,
 *  normals, masks, infrared, truth.
 *  \param folder is looked into, and the folders in it  \param expected where colour is looked for, the end of the line */
std::string unusedImages(const std::string& folder, const std::string& expected);

}  // namespace fuse_flow::io
