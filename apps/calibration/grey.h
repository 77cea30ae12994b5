#pragma once

#include <fuse_flow/recordings/image.h>

#include <cstdint>
#include <vector>

namespace fuse_flow::io {

/** \brief The brightness of an image, row by row, as detectors of markers take it. */
inline std::vector<std::uint8_t> toGrey(const ColorImage& image) {
  std::vector<std::uint8_t> grey;
  grey.reserve(image.data.size());
  for (const Rgb8& c : image.data) grey.push_back(static_cast<std::uint8_t>((77 * c.r + 150 * c.g + 29 * c.b) >> 8));
  return grey;
}

}  // namespace fuse_flow::io
