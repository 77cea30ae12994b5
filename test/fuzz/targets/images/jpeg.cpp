#include "../../fuzz_target.h"
#include "../../image_limits.h"

#include "recordings/images/image_io.h"
#include "recordings/images/jpeg_decode.h"
#include "recordings/images/png_check.h"

#include <fuse_flow/recordings/image.h>

/** \brief A colour image. libjpeg takes its memory in pools, and keeps a progressive image's coefficients. */
FUSE_FLOW_FUZZ_TARGET(jpeg, 1 << 20, 16, 1000) {
  using namespace fuse_flow;
  const std::string bytes(input);
  fuse_flow_fuzz::accepts<io::InputError>([&] {
    io::checkJpeg("color.jpg", bytes);
    io::jpegSize("color.jpg", bytes);
  });
  fuse_flow_fuzz::accepts<io::InputError>([&] {
    io::ColorImage image;
    io::decodeColor("color.jpg", bytes, image, fuse_flow_fuzz::allowImage);
  });
}
