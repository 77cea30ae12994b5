#pragma once

#include <fuse_flow/math/host_device.h>

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
  return (raw > 0) & (raw >= min_range) & (raw <= max_range) ? raw : 0.0f;
}

}  // namespace fuse_flow
