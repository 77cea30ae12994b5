#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief A decoded PNG, grey or RGB, top row first, rows without padding; samples of 8 or 16 bits in the machine's byte
 *  order. */
struct PngPixels {
  int width{0};
  int height{0};
  int channels{0};
  int bits{0};
  std::vector<std::uint8_t> bytes;

  template <typename Sample>
  const Sample* row(int v) const {
    return reinterpret_cast<const Sample*>(bytes.data()) +
           static_cast<std::size_t>(v) * static_cast<std::size_t>(width) * static_cast<std::size_t>(channels);
  }
};

/** \brief Decodes what checkPng() let pass; palettes and 1, 2 or 4 bits become channels of 8 bits, alpha is dropped.
 *  By libpng and not by VTK, whose reader crashes on wrong data in right chunks. Throws InputError, naming path. */
void decodePng(const std::string& path, const std::string& bytes, PngPixels& pixels);

}  // namespace fuse_flow::io
