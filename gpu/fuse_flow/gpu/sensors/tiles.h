#pragma once

#include <fuse_flow/gpu/sensors/device_view.h>

namespace fuse_flow {
namespace gpu {

/** \brief A block of a stencil kernel works on a tile of one chunk by kTileHeight rows, each warp on every kTileWarps-th of
 *  them: most neighbours of a pixel are the block's own and come from the first-level cache, and finding the tile's place costs
 *  little beside its pixels. */
constexpr std::uint32_t kTileWarps = 8;
constexpr std::uint32_t kTileHeight = 32;
constexpr std::uint32_t kTileThreads = kChunk * kTileWarps;

/** \brief All views as tiles, numbered view by view. */
struct TileGrid {
  PixelGrid pixels;
  /** \brief First tile of every view, and the end. */
  const std::uint32_t* offsets;
  std::uint32_t count;

  FUSE_FLOW_HD std::uint32_t viewOf(std::uint32_t tile) const { return lastUpTo(offsets, pixels.view_count, tile); }
};

inline std::uint32_t tilesOf(const DeviceView& view) {
  const auto height = static_cast<std::uint32_t>(view.model.intrinsics.height);
  return view.present ? view.pitch / kChunk * ((height + kTileHeight - 1) / kTileHeight) : 0;
}

/** \brief How many pixels, padding included, and tiles there are. */
struct GridSize {
  std::size_t pixels;
  std::uint32_t tiles;
};

/** \brief Numbers the pixels of views that know their size and whether they are present. \param offsets n + 1 of pixels, then
 *  n + 1 of tiles; right if the number of pixels has 32 bits  \param number_missing whether the pixels of missing views have
 *  numbers too, as if they were there; tiles they have none */
inline GridSize layOutPixels(DeviceView* views, std::size_t n, std::uint32_t* offsets, bool number_missing = false) {
  GridSize size{0, 0};
  for (std::size_t i = 0; i < n; ++i) {
    DeviceView& view = views[i];
    const Intrinsics& K = view.model.intrinsics;
    view.offset = static_cast<std::uint32_t>(size.pixels);
    view.pitch = (static_cast<std::uint32_t>(K.width) + kChunk - 1) / kChunk * kChunk;
    offsets[i] = view.offset;
    offsets[n + 1 + i] = size.tiles;
    if (!view.present && !number_missing) continue;
    size.pixels += std::size_t{view.pitch} * static_cast<std::size_t>(K.height);
    size.tiles += tilesOf(view);
  }
  offsets[n] = static_cast<std::uint32_t>(size.pixels);
  offsets[2 * n + 1] = size.tiles;
  return size;
}

#if FUSE_FLOW_CUDA
/** \brief Calls visit(view, pixel, number) for the pixels of the block's tile that are a thread's, padding included. All threads of
 *  the block must call it; those of a warp have pixels of one chunk. The view is a copy: what follows from it alone is computed once, whatever
 *  visit writes. */
template <typename Visit>
__device__ void forEachPixelOfTileInView(const TileGrid& tiles, const Visit& visit) {
  __shared__ PixelAddress corner;
  if (threadIdx.x == 0) {
    const std::uint32_t i = tiles.viewOf(blockIdx.x);
    const std::uint32_t tile = blockIdx.x - tiles.offsets[i];
    const std::uint32_t tiles_in_row = tiles.pixels.views[i].pitch / kChunk;
    const std::uint32_t row = tile / tiles_in_row;
    corner = {i, static_cast<int>((tile - row * tiles_in_row) * kChunk), static_cast<int>(row * kTileHeight)};
  }
  __syncthreads();
  const DeviceView view = tiles.pixels.views[corner.view];
  const int end = min(corner.v + static_cast<int>(kTileHeight), view.model.intrinsics.height);
  PixelAddress a = corner;
  a.u += static_cast<int>(threadIdx.x % kChunk);
  for (a.v += static_cast<int>(threadIdx.x / kChunk); a.v < end; a.v += static_cast<int>(kTileWarps))
    visit(view, a, view.indexOf(a.u, a.v));
}

/** \brief The same with visit(pixel, number). */
template <typename Visit>
__device__ void forEachPixelOfTile(const TileGrid& tiles, const Visit& visit) {
  forEachPixelOfTileInView(
      tiles, [&visit](const DeviceView&, const PixelAddress& a, std::uint32_t index) { visit(a, index); });
}
#endif

}  // namespace gpu
}  // namespace fuse_flow
