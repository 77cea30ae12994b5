#include "../../fuzz_target.h"
#include "../../scratch.h"

#include "recordings/image_folders/timestamps_file.h"

#include <fuse_flow/recordings/error.h>

/** \brief A timestamps.txt of four images. */
FUSE_FLOW_FUZZ_TARGET(timestamps, 1 << 18, 512, 2000) {
  using namespace fuse_flow;
  const std::string path = fuse_flow_fuzz::scratchFile("timestamps.txt", input);
  io::NamedImages images;
  images.folder = "left/depth";
  for (std::size_t k = 0; k < 4; ++k) images.images.push_back({"00000" + std::to_string(k) + ".png", k, {}});
  std::vector<std::string> warnings;
  fuse_flow_fuzz::accepts<io::InputError>([&] { io::readTimestamps(path, images, warnings); });
}
