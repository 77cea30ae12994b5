#pragma once

#include <fuse_flow/recordings/image.h>

#include <string>

namespace fuse_flow::io {

/** \brief A JPEG of an image, without subsampled chroma. Throws OutputError for an empty image. \param quality 1 … 100 */
std::string encodeJpeg(const ColorImage& image, int quality);

}  // namespace fuse_flow::io
