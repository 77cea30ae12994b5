#pragma once

#include "io/error.h"

#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief Whether there is a file or folder. Throws InputError where that cannot be told, as without permission. */
bool isThere(const std::string& path);

/** \brief The names of what a folder holds, sorted; none where there is no such folder. Throws InputError if it cannot be read. */
std::vector<std::string> filesIn(const std::string& folder);

/** \brief The bytes of a file. Throws InputError if it is not there, is a folder, a pipe, a socket or a device, or cannot be read. */
std::string readFile(const std::string& path);

/** \brief Writes a file so that it appears complete or not at all: beside its place under another name, flushed to the
 *  disk, then renamed. A device or pipe is written directly. Throws OutputError, leaving nothing behind. */
void writeFile(const std::string& path, const std::string& bytes);

/** \brief Throws OptionError if the file that an option names as an output is one of the inputs, the rig.json of one, or an image, a
 *  list of poses or a cloud within one that is a folder: it would be lost. But "-o" may replace a cloud
 *  there: of clouds no recording is made that is a folder. \param option as it is written, "-o"  \param inputs files and folders; an empty name is none */
void refuseToReplace(const std::string& option, const std::string& path, const std::vector<std::string>& inputs);

}  // namespace fuse_flow::io
