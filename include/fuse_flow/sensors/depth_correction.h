#pragma once

#include <fuse_flow/math/depth_correction.h>

#include <vector>

namespace fuse_flow {

/** \brief Corrects depth distortion, an error of a depth camera that is the same at all times. For a measurement z at pixel (u, v), the
 *  true depth is
 *
 *    z (1 + a(u, v) + b(u, v) z),
 *
 *  where a and b are interpolated between the knots of a grid that spans the image, from the centre of its first pixel to the centre of its
 *  last pixel. a is an error of scale. b is an error of the disparity that the sensor, or the network, measures. The first Kinect is off by
 *  ±40 mm at 2 m, in opposite directions left and right. Poses cannot compensate this error. DepthCorrectionEstimation finds the
 *  correction. */
struct DepthCorrection {
  int columns{0};                ///< knots in a row; 0: none, else 2 … 64
  int rows{0};                   ///< rows of knots; 0 or 2 … 64
  std::vector<float> relative;   ///< a, row by row; −0.5 … 0.5
  std::vector<float> per_metre;  ///< b, row by row, 1/metres; −0.5 … 0.5

  /** \brief Whether there is nothing to correct. */
  bool empty() const { return columns == 0; }

  /** \brief Interpolated a and b at pixel (u, v) of an image of width × height pixels. */
  DepthCorrectionTerms at(int u, int v, int width, int height) const {
    if (empty()) return {};
    const float x = width > 1 ? static_cast<float>(u * (columns - 1)) / static_cast<float>(width - 1) : 0.0f;
    const float y = height > 1 ? static_cast<float>(v * (rows - 1)) / static_cast<float>(height - 1) : 0.0f;
    return {betweenKnots(relative.data(), columns, rows, x, y), betweenKnots(per_metre.data(), columns, rows, x, y)};
  }
};

/** \brief Whether two corrections are equal. */
inline bool operator==(const DepthCorrection& a, const DepthCorrection& b) {
  return a.columns == b.columns && a.rows == b.rows && a.relative == b.relative && a.per_metre == b.per_metre;
}
/** \brief Whether two corrections differ. */
inline bool operator!=(const DepthCorrection& a, const DepthCorrection& b) { return !(a == b); }

}  // namespace fuse_flow
