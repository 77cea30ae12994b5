#pragma once

#include <cstddef>

namespace fuse_flow {

/** \brief A camera with nearly all measurements outside [min_range, max_range] of PreprocessingParameters. Usually Camera::depth_scale does
 *  not fit its images. */
struct DepthOutOfRange {
  std::size_t camera{0};    ///< its number in the frame
  std::size_t measured{0};  ///< pixels with a measurement, in range or not
  std::size_t in_range{0};  ///< measured pixels in range
  float nearest{0};         ///< smallest depth of all measured pixels, metres
  float farthest{0};        ///< the largest, metres
};

}  // namespace fuse_flow
