#pragma once

#include <string>

namespace fuse_flow::io {

/** \brief What a PNG's header says. */
struct PngHeader {
  int width{0};
  int height{0};
  /** \brief 1, 2, 4, 8 or 16. */
  int bits{0};
  /** \brief 0 grey, 2 RGB, 3 palette, 4 grey and alpha, 6 RGB and alpha. */
  int color_type{0};
};

bool isPng(const std::string& bytes);

/** \brief Walks all chunks of a PNG and verifies their checksums, because the decoder fills what is missing with black
 *  and says nothing. Throws InputError, naming path, unless the file is whole. */
PngHeader checkPng(const std::string& path, const std::string& bytes);

/** \brief Throws InputError unless the bytes begin as a JPEG does and hold its end; what cameras write behind that is no matter. */
void checkJpeg(const std::string& path, const std::string& bytes);

}  // namespace fuse_flow::io
