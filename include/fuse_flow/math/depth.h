#pragma once

#include <fuse_flow/math/host_device.h>
#include <fuse_flow/sensors/preprocessing.h>

#include <cstdint>

namespace fuse_flow {

/** \brief A 16-bit measurement in metres; 0 where there is none. \param scale metres per unit */
FUSE_FLOW_HD float metres(std::uint16_t raw, float scale, float min_range, float max_range) {
  const float z = scale * static_cast<float>(raw);
  const bool valid = (raw != 0) & (raw != 65535) & (z >= min_range) & (z <= max_range);
  return valid ? z : 0.0f;
}

/** \brief The same of a measurement in metres. NaN and infinities fail the comparisons: max_range is finite. */
FUSE_FLOW_HD float metres(float raw, float min_range, float max_range) {
  const bool valid = (raw > 0) & (raw >= min_range) & (raw <= max_range);
  return valid ? raw : 0.0f;
}

/** \brief Small-hole fill of a pixel without measurement: the mean of its neighbours, if enough are there and they lie on one
 *  surface; else 0. \param z the 3×3 neighbourhood as measured, row by row, metres; 0 or less where there is no measurement */
FUSE_FLOW_HD float filledDepth(const PreprocessingParameters& p, const float (&z)[9]) {
  int count = 0;
  float low = 0, high = 0, sum = 0;
  for (int k = 0; k < 9; ++k) {
    if (!(z[k] > 0)) continue;
    low = count == 0 || z[k] < low ? z[k] : low;
    high = z[k] > high ? z[k] : high;
    sum += z[k];
    ++count;
  }
  if (count < p.fill_neighbours) return 0.0f;
  const float mean = sum / static_cast<float>(count);
  return high - low <= p.fill_tolerance * (mean > 1 ? mean * mean : 1.0f) ? mean : 0.0f;
}

}  // namespace fuse_flow
