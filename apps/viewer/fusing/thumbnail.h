#pragma once

#include <fuse_flow/recordings/recording.h>

namespace fuse_flow::viewing {

/** \brief A small picture of what a camera sees: its colour image, or its depth in grey, near bright, where it has none;
 *  empty if the camera is missing. Nearest pixels. \param height pixels; ≥ 1 */
io::ColorImage thumbnailOf(const Camera& camera, const DepthView& view, int height);

/** \brief Pictures from left to right. */
struct Strip {
  io::ColorImage image;
  std::vector<int> begin;  ///< first column of each picture
};

/** \brief Each with a border of its camera's colour; a missing camera is a black square. As high as the limits allow,
 *  pixels. */
Strip stripOf(const std::vector<io::ColorImage>& thumbnails, int max_width, int max_height);

}  // namespace fuse_flow::viewing
