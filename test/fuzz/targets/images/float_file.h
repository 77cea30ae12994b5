#pragma once

#include "../../fuzz_target.h"
#include "../../image_limits.h"
#include "../../scratch.h"

#include "recordings/images/float_image.h"

#include <fuse_flow/recordings/image.h>

namespace fuse_flow_fuzz {

/** \brief The size alone, and all of it; both say the same size. */
inline void readFloatFile(const char* name, std::string_view input) {
  using namespace fuse_flow;
  const std::string path = scratchFile(name, input);
  io::ImageSize size;
  accepts<io::InputError>([&] { size = io::floatImageSize(path); });
  io::FloatImage image;
  if (accepts<io::InputError>([&] { io::readFloatImage(path, image, allowImage); }))
    require(image.width == size.width && image.height == size.height, "another size than the header's");
}

}  // namespace fuse_flow_fuzz
