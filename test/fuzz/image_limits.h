#pragma once

#include "fuzz_target.h"

#include <fuse_flow/recordings/error.h>

#include <cstddef>

namespace fuse_flow_fuzz {

/** \brief What readers are given to check the size of an image by, as a camera's size is: larger ones are refused, and memory for others is allowed, of the
 *  decoded pixels, of what the library decodes into before, and of a decoder's tables for each column and row. */
inline void allowImage(int width, int height) {
  constexpr int most = 4096;  // pixels in all
  if (width > most || height > most || width * height > most)
    throw fuse_flow::io::InputError("is too large for this test");
  allowMemory(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 64 +
              static_cast<std::size_t>(width + height) * 256);
}

}  // namespace fuse_flow_fuzz
