#pragma once

#include "recordings/images/image_io.h"

#include <string>

namespace fuse_flow::io {

/** \brief Whether readDepthTiff() reads the file, by its extension: .tif or .tiff, also in capitals. */
bool isTiff(const std::string& path);

/** \brief Whether a TIFF has its numbers in float; else they are whole. Throws InputError as readDepthTiff(). */
bool tiffIsFloat(const std::string& path);

/** \brief Reads a TIFF of one channel: 16-bit whole numbers into depth16, 32- or 64-bit float into depth32, and empties the other. Its compression may be
 *  any that libtiff knows, its pixels may be in strips or tiles. Numbers stay as they are. Throws InputError if the file is missing, damaged, cut short,
 *  or of another type. \param check as of readDepthPng() */
void readDepthTiff(const std::string& path, DepthImage& depth16, FloatImage& depth32, const SizeCheck& check = {});

}  // namespace fuse_flow::io
