#pragma once

#include "recordings/image_folders/image_names.h"

#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief Gives images the times of a timestamps.txt, in place of those in their names.
 *
 *  A line is a time alone, and then there is one for each image in their order; or a time and the image's name, in either order (the name
 *  with or without its folder, with or without its extension, or its number). Commas separate as spaces do; what begins with # is a
 *  comment. The unit is told by stampUnit(). Images that the file does not name are left out, which a warning says, and so it says
 *  lines whose image is not there. Throws InputError. */
void readTimestamps(const std::string& path, NamedImages& images, std::vector<std::string>& warnings);

}  // namespace fuse_flow::io
