#pragma once

#include <fuse_flow/math/host_device.h>

namespace fuse_flow {

/** \brief How far a depth camera is from the truth at one pixel: see DepthCorrection. */
struct DepthCorrectionTerms {
  float relative{0};   ///< a, share of the depth
  float per_metre{0};  ///< b, more of it for each metre, 1/metres
};

/** \brief z (1 + a + b z), metres; 0 where there is no measurement, or the terms leave none. \param z as measured, metres; 0: none */
FUSE_FLOW_HD float correctedDepth(float z, const DepthCorrectionTerms& terms) {
  const float corrected = z * (1.0f + terms.relative + terms.per_metre * z);
  return corrected > 0 ? corrected : 0.0f;
}

/** \brief Between the four knots around a pixel. \param knots row by row  \param columns of them; ≥ 2  \param rows ≥ 2
 *  \param x in columns from the first knot, 0 … columns − 1  \param y in rows */
FUSE_FLOW_HD float betweenKnots(const float* knots, int columns, int rows, float x, float y) {
  int i = static_cast<int>(x), j = static_cast<int>(y);
  i = i < columns - 2 ? i : columns - 2;
  j = j < rows - 2 ? j : rows - 2;
  const float* k = knots + j * columns + i;
  const float right = x - static_cast<float>(i), down = y - static_cast<float>(j);
  const float above = k[0] + right * (k[1] - k[0]), below = k[columns] + right * (k[columns + 1] - k[columns]);
  return above + down * (below - above);
}

}  // namespace fuse_flow
