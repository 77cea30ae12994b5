#pragma once

#include <cstdint>
#include <cstdio>  // before jpeglib.h, which needs it
#include <stdexcept>
#include <string>
#include <vector>

#include <jpeglib.h>

namespace fuse_flow::test {

struct DecodedJpeg {
  int width{0}, height{0};
  std::vector<std::uint8_t> rgb;  ///< top row first
};

/** \brief Throws for what is no whole JPEG. */
inline DecodedJpeg decodedJpeg(const std::string& bytes) {
  jpeg_decompress_struct info;
  jpeg_error_mgr errors;
  info.err = jpeg_std_error(&errors);
  errors.error_exit = [](j_common_ptr) { throw std::runtime_error("no JPEG"); };
  errors.emit_message = [](j_common_ptr, int level) {
    if (level < 0) throw std::runtime_error("a damaged JPEG");
  };
  jpeg_create_decompress(&info);
  jpeg_mem_src(&info, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  jpeg_read_header(&info, TRUE);
  info.out_color_space = JCS_RGB;
  jpeg_start_decompress(&info);
  DecodedJpeg image{static_cast<int>(info.output_width), static_cast<int>(info.output_height), {}};
  const std::size_t row_bytes = 3 * std::size_t{info.output_width};
  image.rgb.resize(row_bytes * info.output_height);
  while (info.output_scanline < info.output_height) {
    auto* row = static_cast<JSAMPROW>(&image.rgb[row_bytes * info.output_scanline]);
    jpeg_read_scanlines(&info, &row, 1);
  }
  jpeg_finish_decompress(&info);
  jpeg_destroy_decompress(&info);
  return image;
}

}  // namespace fuse_flow::test
