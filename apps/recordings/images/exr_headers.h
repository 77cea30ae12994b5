#pragma once

#include <string>

namespace fuse_flow::io {

/** \brief Throws std::runtime_error unless all attributes of an OpenEXR file lie within it, and are as long as their types are, and the file has room for the
 *  blocks of pixels that they tell of. OpenEXR takes memory by these sizes before it looks, and reads on where a value ends. */
void checkExrHeaders(const std::string& bytes);

}  // namespace fuse_flow::io
