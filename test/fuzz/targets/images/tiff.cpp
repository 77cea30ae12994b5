#include "../../fuzz_target.h"
#include "../../image_limits.h"
#include "../../scratch.h"

#include "recordings/images/tiff_image.h"

#include <fuse_flow/recordings/image.h>

/** \brief Depth in TIFF. libtiff takes memory for its tags, for a strip or tile, for its codecs, and 16 bytes for each strip that the header tells of:
 *  up to a million it believes. */
FUSE_FLOW_FUZZ_TARGET(tiff, 20 << 20, 64, 500) {
  using namespace fuse_flow;
  const std::string path = fuse_flow_fuzz::scratchFile("depth.tif", input);
  fuse_flow_fuzz::accepts<io::InputError>([&] { io::tiffIsFloat(path); });
  fuse_flow_fuzz::accepts<io::InputError>([&] {
    io::DepthImage depth16;
    io::FloatImage depth32;
    io::readDepthTiff(path, depth16, depth32, fuse_flow_fuzz::allowImage);
  });
}
