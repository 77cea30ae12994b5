#pragma once

#include <fuse_flow/recordings/recording.h>

#include <cstddef>

namespace fuse_flow::io {

/** \brief Empties the images that a frame's views do not have. Frames are read into the same memory again and again, and an image that is absent leaves the
 *  pixels of an earlier frame there: for those who take images and not views. */
inline void clearAbsentImages(LoadedFrame& frame) {
  for (std::size_t k = 0; k < frame.images.size(); ++k) {
    const DepthView& view = frame.rig.views[k];
    LoadedView& images = frame.images[k];
    if (!view.depth16) images.depth16.resize(0, 0);
    if (!view.depth32) images.depth32.resize(0, 0);
    if (!view.color) images.color.resize(0, 0);
    if (!view.confidence) images.confidence.resize(0, 0);
  }
}

}  // namespace fuse_flow::io
