#include "recordings/images/jpeg_decode.h"

#include "recordings/images/plausible_size.h"

#include <fuse_flow/recordings/error.h>

#include <csetjmp>
#include <cstdio>  // before jpeglib.h, which needs it

#include <jpeglib.h>

namespace fuse_flow::io {
namespace {

/** \brief libjpeg's errors, and where it jumps to when it gives up. */
struct JpegErrors {
  jpeg_error_mgr manager;
  std::jmp_buf give_up;
};

[[noreturn]] void fail(j_common_ptr info) { std::longjmp(reinterpret_cast<JpegErrors*>(info->err)->give_up, 1); }

/** \brief Nothing is printed; of warnings, which have a negative level, the first is enough. */
void onMessage(j_common_ptr info, int level) {
  if (level < 0) fail(info);
}

/** \brief A JPEG whose header has been read: what else reads it could be led to another size. */
class Jpeg {
 public:
  /** \param bytes must stay */
  Jpeg(const std::string& path, const std::string& bytes) : path_(path) {
    info_.err = jpeg_std_error(&errors_.manager);
    errors_.manager.error_exit = fail;
    errors_.manager.emit_message = onMessage;
    if (!readHeader(bytes)) {
      jpeg_destroy_decompress(&info_);
      throwDamaged();
    }
  }
  ~Jpeg() { jpeg_destroy_decompress(&info_); }
  Jpeg(const Jpeg&) = delete;
  Jpeg& operator=(const Jpeg&) = delete;

  ImageSize size() const { return {static_cast<int>(info_.image_width), static_cast<int>(info_.image_height)}; }
  int channels() const { return info_.num_components; }

  /** \brief RGB, top row first. \param image of its size */
  void decode(ColorImage& image) {
    if (!decodeRows(image)) throwDamaged();
  }

 private:
  // In these nothing has a destructor that the jump would pass over.
  bool readHeader(const std::string& bytes) {
    if (setjmp(errors_.give_up)) return false;
    jpeg_create_decompress(&info_);
    jpeg_mem_src(&info_, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
    jpeg_read_header(&info_, TRUE);
    return true;
  }
  bool decodeRows(ColorImage& image) {
    if (setjmp(errors_.give_up)) return false;
    info_.out_color_space = JCS_RGB;
    jpeg_start_decompress(&info_);
    while (info_.output_scanline < info_.output_height) {
      auto* row = reinterpret_cast<JSAMPROW>(&image.at(0, static_cast<int>(info_.output_scanline)));
      jpeg_read_scanlines(&info_, &row, 1);
    }
    jpeg_finish_decompress(&info_);
    return true;
  }
  [[noreturn]] void throwDamaged() const {
    throw InputError(path_ + ": is damaged and cannot be decoded, must be a whole JPEG");
  }

  std::string path_;
  JpegErrors errors_{};
  jpeg_decompress_struct info_{};
};

}  // namespace

void decodeJpeg(const std::string& path, const std::string& bytes, ColorImage& image, const SizeCheck& check) {
  Jpeg jpeg(path, bytes);
  const ImageSize size = jpeg.size();
  if (check) check(size.width, size.height);
  if (jpeg.channels() != 1 && jpeg.channels() != 3)  // a printer's four inks
    throw InputError(path + ": is a JPEG of " + std::to_string(jpeg.channels()) + " channels, must be grey or RGB");
  checkPlausible(path, size.width, size.height, bytes.size(), kMostOfJpegByte);
  image.resize(size.width, size.height);
  jpeg.decode(image);
}

ImageSize jpegSize(const std::string& path, const std::string& bytes) { return Jpeg(path, bytes).size(); }

}  // namespace fuse_flow::io
