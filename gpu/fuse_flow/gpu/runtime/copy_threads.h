#pragma once

#include <fuse_flow/impl/host/parallel.hpp>

#include <algorithm>
#include <cstddef>

namespace fuse_flow {
namespace gpu {

/** \brief Host threads that copy the images or the points of a frame, for a setting of n. 0: as many as bring memory to its bandwidth; more
 *  of them only wait, and beside other programs for each other. \param frames that share them */
inline int copyThreads(int n, std::size_t frames = 1) {
  constexpr int enough = 16;
  const int share = std::max(1, host::resolveThreads(n) / static_cast<int>(frames));
  return n > 0 ? share : std::min(share, enough);
}

}  // namespace gpu
}  // namespace fuse_flow
