#include "recordings/images/jpeg_encode.h"

#include "recordings/images/jpeg_bytes.h"

#include <fuse_flow/recordings/error.h>

#include <string>

namespace fuse_flow::io {

std::string encodeJpeg(const ColorImage& image, int quality) {
  if (image.empty()) throw OutputError("there is no image to encode");
  if (image.width > JPEG_MAX_DIMENSION || image.height > JPEG_MAX_DIMENSION)
    throw OutputError("an image of " + std::to_string(image.width) + "x" + std::to_string(image.height) +
                      " cannot be a JPEG, must have sides of at most " + std::to_string(JPEG_MAX_DIMENSION) +
                      " pixels");
  return jpegBytes(image.view(), quality, false);
}

}  // namespace fuse_flow::io
