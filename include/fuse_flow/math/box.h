#pragma once

#include <fuse_flow/math/vec3.h>

#include <cmath>

namespace fuse_flow {

/** \brief A box along the axes of the world, borders included; by default all of it. Eigen's has no device code. */
struct Box {
  Vec3 low{-INFINITY, -INFINITY, -INFINITY};  ///< metres
  Vec3 high{INFINITY, INFINITY, INFINITY};    ///< metres

  /** \brief Whether a point lies inside. Without branches, so that loops over it become vector code. */
  FUSE_FLOW_HD bool contains(const Vec3& p) const {
    const bool outside =
        (p.x < low.x) | (p.x > high.x) | (p.y < low.y) | (p.y > high.y) | (p.z < low.z) | (p.z > high.z);
    return !outside;
  }
};

}  // namespace fuse_flow
