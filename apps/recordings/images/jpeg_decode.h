#pragma once

#include "recordings/images/image_io.h"

#include <fuse_flow/recordings/image.h>

#include <string>

namespace fuse_flow::io {

/** \brief Decodes what checkJpeg() let pass; grey is spread over the three channels. By libjpeg and not by VTK, whose readers share what they say about
 *  errors among threads. What it warns of is damage, too. Throws InputError, naming path. \param check see SizeCheck: the size that is decoded */
void decodeJpeg(const std::string& path, const std::string& bytes, ColorImage& image, const SizeCheck& check);

/** \brief The size of a JPEG, without decoding it. Throws InputError. */
ImageSize jpegSize(const std::string& path, const std::string& bytes);

}  // namespace fuse_flow::io
