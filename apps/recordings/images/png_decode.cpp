#include "recordings/images/png_decode.h"

#include <fuse_flow/recordings/error.h>

#include <png.h>

#include <algorithm>
#include <csetjmp>
#include <cstring>

namespace fuse_flow::io {
namespace {

/** \brief What libpng reads from, and what it said before it gave up. */
struct Source {
  const std::string& bytes;
  std::size_t at{0};
  char problem[128]{};
};

void readBytes(png_structp png, png_bytep to, std::size_t count) {
  auto& source = *static_cast<Source*>(png_get_io_ptr(png));
  if (count > source.bytes.size() - source.at) png_error(png, "data ends early");
  std::memcpy(to, source.bytes.data() + source.at, count);
  source.at += count;
}

[[noreturn]] void fail(png_structp png, png_const_charp message) {
  auto& source = *static_cast<Source*>(png_get_error_ptr(png));
  std::strncpy(source.problem, message, sizeof source.problem - 1);
  png_longjmp(png, 1);
}

void ignoreWarning(png_structp, png_const_charp) {}

/** \brief Grey or RGB of 8 or 16 bits a channel, in the machine's byte order. */
void setTransformations(png_structp png) {
  png_set_expand(png);
  png_set_strip_alpha(png);
#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
  png_set_swap(png);
#endif
  png_set_interlace_handling(png);
}

void resize(png_structp png, png_infop info, PngPixels& pixels) {
  pixels.width = static_cast<int>(png_get_image_width(png, info));
  pixels.height = static_cast<int>(png_get_image_height(png, info));
  pixels.channels = png_get_channels(png, info);
  pixels.bits = png_get_bit_depth(png, info);
  const std::size_t size = png_get_rowbytes(png, info) * static_cast<std::size_t>(pixels.height);
  // Deflate shrinks to a thousandth at best: a header that claims more would only take the memory.
  constexpr std::size_t best_compression = 1100;
  if (size / best_compression > static_cast<Source*>(png_get_io_ptr(png))->bytes.size())
    png_error(png, "less data than its size needs");
  pixels.bytes.resize(size);
}

/** \brief False once libpng has given up. Nothing here has a destructor that the jump would pass over. */
bool decode(png_structp png, png_infop info, PngPixels& pixels, std::vector<png_bytep>& rows) {
  if (setjmp(png_jmpbuf(png))) return false;
  png_read_info(png, info);
  setTransformations(png);
  png_read_update_info(png, info);
  resize(png, info, pixels);
  const std::size_t row_bytes = png_get_rowbytes(png, info);
  rows.resize(static_cast<std::size_t>(pixels.height));
  for (std::size_t v = 0; v < rows.size(); ++v) rows[v] = pixels.bytes.data() + v * row_bytes;
  png_read_image(png, rows.data());
  png_read_end(png, nullptr);
  return true;
}

}  // namespace

void decodePng(const std::string& path, const std::string& bytes, PngPixels& pixels) {
  Source source{bytes};
  std::vector<png_bytep> rows;
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &source, fail, ignoreWarning);
  png_infop info = png ? png_create_info_struct(png) : nullptr;
  bool decoded = false;
  if (info) {
    png_set_read_fn(png, &source, readBytes);
    decoded = decode(png, info, pixels, rows);
  }
  png_destroy_read_struct(&png, &info, nullptr);
  if (!decoded) throw InputError(path + ": is damaged: " + source.problem + "; must be a whole PNG");
}

}  // namespace fuse_flow::io
