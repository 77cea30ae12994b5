#pragma once

#include "recordings/images/image_io.h"

#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief Extensions of the files that readFloatImage() reads, as programs that estimate depth write them. */
const std::vector<std::string>& floatImageExtensions();

/** \brief Whether readFloatImage() reads the file, by its extension. */
bool isFloatImage(const std::string& path);

/** \brief The size that a file of readFloatImage() says it has; of the file nothing but its header is decoded. Throws InputError as that does. */
ImageSize floatImageSize(const std::string& path);

/** \brief Reads one channel of numbers, top row first, chosen by the extension: .pfm (Portable Float Map), .npy (NumPy: height × width,
 *  perhaps with more sides of 1, in C order, float32 or float64), .bin (COLMAP's depth map) or .exr (readExr()). Numbers stay as they are, NaN too. Throws
 *  InputError if the file is missing, cut short, or of another type. \param check as of readDepthPng() */
void readFloatImage(const std::string& path, FloatImage& image, const SizeCheck& check = {});

/** \brief Writes an image as NumPy's .npy: float32, height × width. Throws OutputError. */
void writeNpy(const std::string& path, const FloatImage& image);

}  // namespace fuse_flow::io
