#pragma once

#include <fuse_flow/impl/host/parallel.hpp>

#include <algorithm>
#include <cstddef>

namespace fuse_flow::simulation {

/** \brief Calls body(k) for k < n in blocks, on several threads. */
template <typename Body>
void forEachPoint(std::size_t n, int threads, const Body& body) {
  constexpr std::size_t block = 4096;
  host::parallelFor(threads, (n + block - 1) / block, [&](std::size_t b, int) {
    for (std::size_t k = b * block; k < std::min(n, (b + 1) * block); ++k) body(k);
  });
}

}  // namespace fuse_flow::simulation
