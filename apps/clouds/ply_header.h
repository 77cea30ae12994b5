#pragma once

#include <string>

namespace fuse_flow::io {

/** \brief Throws InputError for a PLY at which PCL's reader would end the program: with bytes of red, green and blue that are not all there in this
 *  order, with alpha without colour or twice, with lists in its vertices, with rows and columns that are not as many, with white space
 *  before those, or with a grid of them, whose numbers it does not check. Also for one that is too short for what its header tells of: the reader takes memory by that first. */
void checkPlyHeader(const std::string& path);

}  // namespace fuse_flow::io
