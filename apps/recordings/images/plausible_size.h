#pragma once

#include <fuse_flow/recordings/error.h>

#include <cstddef>
#include <string>

namespace fuse_flow::io {

/** \brief Pixels that a byte of a JPEG can hold: Huffman's codes take a bit at least for a block of 64. */
constexpr std::size_t kMostOfJpegByte = 1024;
/** \brief The same of the compressions of TIFF and OpenEXR, of which Zstandard makes 128 KiB of some four bytes. */
constexpr std::size_t kMostOfAnyByte = 40'000;

/** \brief Throws InputError where a file is too short for an image of the size that it claims: who takes memory by that size asks before. A SizeCheck is not
 *  enough, where the size that it allows is of a small file, too.
 *  \param bytes of the file  \param most pixels that a byte can hold */
inline void checkPlausible(const std::string& path, int width, int height, std::size_t bytes, std::size_t most) {
  if (static_cast<std::size_t>(width) * static_cast<std::size_t>(height) / most <= bytes) return;
  throw InputError(path + ": is damaged or cut short: it says that it is " + std::to_string(width) + "x" +
                   std::to_string(height) + " pixels, which is more than " + std::to_string(bytes) + " bytes can hold");
}

}  // namespace fuse_flow::io
