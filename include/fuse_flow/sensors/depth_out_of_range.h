#pragma once

#include <cstddef>

namespace fuse_flow {

/** \brief A camera nearly all of whose measurements lie outside [min_range, max_range] of PreprocessingParameters: more often than not
 *  Camera::depth_scale is not that of its images. */
struct DepthOutOfRange {
  std::size_t camera{0};    ///< its number in the frame
  std::size_t measured{0};  ///< pixels with a measurement, whatever its range
  std::size_t in_range{0};  ///< those of them that count
  float nearest{0};         ///< the least depth of all of them, metres, as measured
  float farthest{0};        ///< the largest, metres
};

}  // namespace fuse_flow
