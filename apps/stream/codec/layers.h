#pragma once

#include <fuse_flow/math/host_device.h>

#include <cstddef>
#include <cstdint>

namespace fuse_flow::stream {

/** \brief Layers of a chunk of `points` points: layer 0 has each `stride`-th, each later one those halfway between. */
struct Layer {
  std::size_t stride, first,
      between;  ///< ranks first, first + between, … below the number of points; neighbours at ± stride

  FUSE_FLOW_HD Layer(int layer, int layers)
      : stride(std::size_t{1} << (layers - 1 - layer)),
        first(layer == 0 ? 0 : stride),
        between(layer == 0 ? stride : 2 * stride) {}

  FUSE_FLOW_HD std::size_t points(std::size_t of_chunk) const {
    return of_chunk > first ? (of_chunk - first + between - 1) / between : 0;
  }
};

/** \brief Points of the first `layers` layers of all: every `stride`-th. */
FUSE_FLOW_HD std::size_t pointsUpTo(std::size_t of_chunk, int layers_here, int layers) {
  if (layers_here <= 0) return 0;
  const std::size_t stride = std::size_t{1} << (layers - layers_here);
  return (of_chunk + stride - 1) / stride;
}

}  // namespace fuse_flow::stream
