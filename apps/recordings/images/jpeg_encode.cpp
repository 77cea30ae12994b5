#include "recordings/images/jpeg_encode.h"

#include <fuse_flow/recordings/error.h>

#include <cstdio>  // before jpeglib.h, which needs it
#include <cstdlib>
#include <string>

#include <jpeglib.h>

namespace fuse_flow::io {

std::string encodeJpeg(const ColorImage& image, int quality) {
  if (image.empty()) throw OutputError("there is no image to encode");
  if (image.width > JPEG_MAX_DIMENSION || image.height > JPEG_MAX_DIMENSION)
    throw OutputError("an image of " + std::to_string(image.width) + "x" + std::to_string(image.height) +
                      " cannot be a JPEG, must have sides of at most " + std::to_string(JPEG_MAX_DIMENSION) +
                      " pixels");
  jpeg_error_mgr errors;
  jpeg_compress_struct info;
  info.err = jpeg_std_error(
      &errors);  // of a whole image in memory nothing can go wrong but memory, and then it ends the program
  jpeg_create_compress(&info);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&info, &bytes, &size);
  info.image_width = static_cast<JDIMENSION>(image.width);
  info.image_height = static_cast<JDIMENSION>(image.height);
  info.input_components = 3;
  info.in_color_space = JCS_RGB;
  jpeg_set_defaults(&info);
  jpeg_set_quality(&info, quality, TRUE);
  info.comp_info[0].h_samp_factor = info.comp_info[0].v_samp_factor = 1;
  jpeg_start_compress(&info, TRUE);
  for (int v = 0; v < image.height; ++v) {
    auto* row = reinterpret_cast<JSAMPROW>(const_cast<Rgb8*>(&image.at(0, v)));
    jpeg_write_scanlines(&info, &row, 1);
  }
  jpeg_finish_compress(&info);
  std::string jpeg(reinterpret_cast<const char*>(bytes), size);
  jpeg_destroy_compress(&info);
  std::free(bytes);
  return jpeg;
}

}  // namespace fuse_flow::io
