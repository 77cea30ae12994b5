#pragma once

#include <fuse_flow/gpu/device_view.h>

namespace fuse_flow {
namespace gpu {

/** \brief Pixels that one block of a stencil kernel works on: kTileRows rows of one chunk, so that most neighbours of a pixel
 *  are other threads' pixels and come from the first-level cache. */
constexpr std::uint32_t kTileRows = 8;
constexpr std::uint32_t kTileThreads = kChunk * kTileRows;

/** \brief All views as tiles, numbered view by view. */
struct TileGrid {
  PixelGrid pixels;
  /** \brief First tile of every view, and the end. */
  const std::uint32_t* offsets;
  std::uint32_t count;
};

inline std::uint32_t tilesOf(const DeviceView& view) {
  const auto height = static_cast<std::uint32_t>(view.model.intrinsics.height);
  return view.present ? view.pitch / kChunk * ((height + kTileRows - 1) / kTileRows) : 0;
}

#if FUSE_FLOW_CUDA
/** \brief The pixel of a thread of a block of kTileThreads; false below the image. All threads must call it. */
__device__ inline bool pixelOfTile(const TileGrid& tiles, PixelAddress& a) {
  __shared__ std::uint32_t view_of_block;
  if (threadIdx.x == 0) {
    std::uint32_t low = 0, high = tiles.pixels.view_count;  // offsets[low] ≤ block < offsets[high]
    while (high - low > 1) {
      const std::uint32_t middle = (low + high) / 2;
      if (tiles.offsets[middle] <= blockIdx.x) {
        low = middle;
      } else {
        high = middle;
      }
    }
    view_of_block = low;
  }
  __syncthreads();
  a.view = view_of_block;
  const DeviceView& view = tiles.pixels.views[a.view];
  const std::uint32_t tile = blockIdx.x - tiles.offsets[a.view];
  const std::uint32_t tiles_in_row = view.pitch / kChunk;
  const std::uint32_t row = tile / tiles_in_row;
  a.u = static_cast<int>((tile - row * tiles_in_row) * kChunk + threadIdx.x % kChunk);
  a.v = static_cast<int>(row * kTileRows + threadIdx.x / kChunk);
  return a.v < view.model.intrinsics.height;
}
#endif

}  // namespace gpu
}  // namespace fuse_flow
