#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace tool_test {

/** \brief A PNG put together chunk by chunk, independent of the library under test, so that it can also be a wrong one.
 */
std::string pngChunk(const std::string& type, const std::string& data);
/** \brief The header chunk. \param color_type 0 grey, 2 RGB */
std::string pngHeader(int width, int height, int bits, int color_type);
/** \brief zlib data in stored blocks: no compression. */
std::string zlibStored(const std::string& data);
/** \brief The signature, chunks, and the end. */
std::string png(const std::string& chunks);

/** \brief A whole image from its samples, row by row, as a PNG stores them: most significant byte first. */
std::string samplesPng(int width, int height, int bits, int color_type, const std::string& samples);

/** \brief A whole 16-bit grey image. */
std::string depthPng(int width, int height, const std::vector<std::uint16_t>& pixels);
/** \brief A whole 8-bit RGB image of one colour. */
std::string colorPng(int width, int height, std::uint8_t r, std::uint8_t g, std::uint8_t b);

}  // namespace tool_test
