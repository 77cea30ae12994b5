#pragma once

#include "recordings/images/image_io.h"

#include <string>

namespace fuse_flow::io {

/** \brief The size of an OpenEXR image. Throws InputError as readExr(). */
ImageSize exrSize(const std::string& path);

/** \brief Reads the channel of depth of an OpenEXR image, half or float: Z, or that of a layer Depth; else V, or the only one, or Y, or R where
 *  red, green and blue are the same. A number of 1e9 or more, of half the largest, is where nothing was measured, as Blender writes it, and becomes infinity; other numbers stay as they are.
 *  Throws InputError if the file is missing, damaged, or has no such channel, and where FUSE-Flow was built without OpenEXR. \param check as of readDepthPng() */
void readExr(const std::string& path, FloatImage& image, const SizeCheck& check = {});

}  // namespace fuse_flow::io
