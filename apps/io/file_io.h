#pragma once

#include "io/error.h"

#include <string>

namespace fuse_flow::io {

/** \brief The bytes of a file. Throws InputError if it is not there, is a folder, or cannot be read. */
std::string readFile(const std::string& path);

/** \brief Writes a file so that it appears complete or not at all: beside its place under another name, flushed to the
 *  disk, then renamed. A device or pipe is written directly. Throws OutputError, leaving nothing behind. */
void writeFile(const std::string& path, const std::string& bytes);

}  // namespace fuse_flow::io
