#pragma once

#include <fuse_flow/depth_view.h>

#include <cstdio>  // before jpeglib.h, which needs it
#include <cstdlib>
#include <memory>
#include <string>

#include <jpeglib.h>

namespace fuse_flow::io {

/** \brief A JPEG. In a header, as FuseFlow::stream encodes images, too, and is linked without FuseFlow::recordings.
 *  \param image not empty, with sides of at most JPEG_MAX_DIMENSION pixels  \param quality 1 … 100
 *  \param half_chroma colour at half the resolution, as most cameras store it: fewer bytes, and faster */
inline std::string jpegBytes(const ImageView<Rgb8>& image, int quality, bool half_chroma) {
  jpeg_error_mgr errors;
  jpeg_compress_struct info;
  info.err = jpeg_std_error(
      &errors);  // of a whole image in memory nothing can go wrong but memory, and then it ends the program
  jpeg_create_compress(&info);
  unsigned char* bytes = nullptr;
  const auto release = [&bytes](jpeg_compress_struct* used) {
    jpeg_destroy_compress(used);
    std::free(bytes);
  };
  const std::unique_ptr<jpeg_compress_struct, decltype(release)> released(&info, release);
  unsigned long size = 0;
  jpeg_mem_dest(&info, &bytes, &size);
  info.image_width = static_cast<JDIMENSION>(image.width);
  info.image_height = static_cast<JDIMENSION>(image.height);
  info.input_components = 3;
  info.in_color_space = JCS_RGB;
  jpeg_set_defaults(&info);
  jpeg_set_quality(&info, quality, TRUE);
  info.comp_info[0].h_samp_factor = info.comp_info[0].v_samp_factor = half_chroma ? 2 : 1;
  jpeg_start_compress(&info, TRUE);
  for (int v = 0; v < image.height; ++v) {
    auto* row = reinterpret_cast<JSAMPROW>(const_cast<Rgb8*>(image.row(v)));
    jpeg_write_scanlines(&info, &row, 1);
  }
  jpeg_finish_compress(&info);
  return std::string(reinterpret_cast<const char*>(bytes), size);
}

}  // namespace fuse_flow::io
