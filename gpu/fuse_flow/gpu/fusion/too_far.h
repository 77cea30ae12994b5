#pragma once

#include <fuse_flow/math/cell.h>

#include <pcl/exceptions.h>

#include <sstream>

namespace fuse_flow {
namespace gpu {

/** \brief As the CPU says it. */
[[noreturn]] inline void throwTooFar(const Vec3& p, float cell_size) {
  std::ostringstream message;
  message << "fuse_flow::AdaptiveHashFusion: point (" << p.x << ", " << p.y << ", " << p.z << ") m is more than "
          << kMaxCellCoordinate << " cells of " << cell_size << " m from the origin";
  throw pcl::PCLException(message.str());
}

}  // namespace gpu
}  // namespace fuse_flow
