#pragma once

#include <fuse_flow/gpu/sensors/device_view.h>
#include <fuse_flow/math/calibration/block_average.h>

namespace fuse_flow {
namespace gpu {

/** \brief The maps of all blocks, by their numbers in the grid of blocks. */
struct BlockPointers {
  PixelGrid grid;
  const float* z;
  const Ray* rays;

  /** \brief Those of one view. */
  FUSE_FLOW_HD BlockMap of(const DeviceView& view) const {
    BlockMap map;
    map.z = z + view.offset;
    map.rays = rays + view.offset;
    map.z_pitch = map.pitch = static_cast<std::ptrdiff_t>(view.pitch);
    map.width = view.model.intrinsics.width;
    map.height = view.model.intrinsics.height;
    return map;
  }
};

/** \brief Depth of one block, its inverse, and the ray through its middle. */
struct AverageBlocks {
  PixelGrid blocks;
  const DeviceView* full;  // the images' views, with their noise …
  const float* full_z;     // … and depth
  float steepest;
  float* z;
  float* q;
  Ray* rays;

  FUSE_FLOW_HD void operator()(std::uint32_t index) const {
    const PixelAddress a = blocks.addressOf(index);
    const DeviceView& view = full[a.view];
    const int reduction = blocks.views[a.view].reduction;
    float mean = 0;
    if (a.u < blocks.views[a.view].model.intrinsics.width) {
      BlockDepth block;
      for (int dv = 0; dv < reduction; ++dv) {
        const float* row = full_z + view.indexOf(a.u * reduction, a.v * reduction + dv);
        for (int du = 0; du < reduction; ++du) block.add(row[du]);
      }
      mean = block.mean(view.model.intrinsics, reduction, steepest, view.noise.model, view.noise.scale);
    }
    z[index] = mean;
    q[index] = mean > 0 ? 1.0f / mean : 0.0f;
    rays[index] = blockRay(view.model.intrinsics, reduction, a.u, a.v);
  }
};

/** \brief Inverse depth of one block without what sticks out on all sides. */
struct DespeckleBlocks {
  PixelGrid blocks;
  const float* q;
  float largest;  // see ExtrinsicParameters::max_speckle
  float* despeckled;

  FUSE_FLOW_HD void operator()(std::uint32_t index) const {
    const PixelAddress a = blocks.addressOf(index);
    const DeviceView& view = blocks.views[a.view];
    const float centre = q[index];
    despeckled[index] = centre;
    if (!(centre > 0)) return;
    float patch[9];
    for (int k = 0; k < 9; ++k) patch[k] = at(view, a.u + k % 3 - 1, a.v + k / 3 - 1);
    despeckled[index] =
        despeckledInverseDepth(patch, speckleBound(largest, view.noise.model, view.noise.scale, centre));
  }

  /** \brief 0 beside the image. */
  FUSE_FLOW_HD float at(const DeviceView& view, int u, int v) const {
    const Intrinsics& K = view.model.intrinsics;
    return ((u >= 0) & (v >= 0) & (u < K.width) & (v < K.height)) ? q[view.indexOf(u, v)] : 0.0f;
  }
};

/** \brief Normal of one block; zero along the border, where neighbours are missing. */
struct FindNormals {
  BlockPointers measured, smooth;
  float tolerance;  // of the smoothing, in standard deviations of second differences
  Vec3* normals;

  FUSE_FLOW_HD void operator()(std::uint32_t index) const {
    const PixelAddress a = measured.grid.addressOf(index);
    const DeviceView& view = measured.grid.views[a.view];
    const Intrinsics& K = view.model.intrinsics;
    constexpr int step = kNormalSpacing;
    const bool inside = (a.u >= step) & (a.v >= step) & (a.u < K.width - step) & (a.v < K.height - step);
    normals[index] = inside ? blockNormal(smooth.of(view), a.u, a.v, measured.of(view).point(a.u, a.v),
                                          view.noise.model, tolerance * view.noise.scale)
                            : Vec3{};
  }
};

/** \brief Grey level of one pixel of the images; negative where there is no depth, or the view has no colour. */
struct PixelLuma {
  BlockPointers blocks;
  PixelGrid full;
  float* grey;  // pixel by pixel

  FUSE_FLOW_HD void operator()(std::uint32_t index) const {
    const PixelAddress a = full.addressOf(index);
    const DeviceView& view = full.views[a.view];
    const DeviceView& of_blocks = blocks.grid.views[a.view];
    const int u = a.u / of_blocks.reduction, v = a.v / of_blocks.reduction;
    const bool inside = (u < of_blocks.model.intrinsics.width) & (v < of_blocks.model.intrinsics.height);
    grey[index] = view.color && inside ? pixelLuma(view.model, view.color, a.u, a.v, view.ray(a.u, a.v),
                                                   blocks.z[of_blocks.indexOf(u, v)])
                                       : -1.0f;
  }
};

/** \brief Mean grey level of the square as large as a block that begins at one pixel; negative where a pixel of it has none. */
struct SquareLuma {
  const DeviceView* blocks;
  PixelGrid full;
  const float* grey;
  float* squares;

  FUSE_FLOW_HD void operator()(std::uint32_t index) const {
    const PixelAddress a = full.addressOf(index);
    const DeviceView& view = full.views[a.view];
    const int side = blocks[a.view].reduction;
    const Intrinsics& K = view.model.intrinsics;
    const bool inside = (a.u + side <= K.width) & (a.v + side <= K.height);
    squares[index] =
        view.color && inside ? squareLuma(grey + index, static_cast<std::ptrdiff_t>(view.pitch), side) : -1.0f;
  }
};

/** \brief Mean grey level of one block; negative where there is none. */
struct BlockLuma {
  PixelGrid blocks;
  const DeviceView* full;
  const float* squares;
  float* luma;

  FUSE_FLOW_HD void operator()(std::uint32_t index) const {
    const PixelAddress a = blocks.addressOf(index);
    const DeviceView& view = full[a.view];
    const DeviceView& of_blocks = blocks.views[a.view];
    const bool inside = (a.u < of_blocks.model.intrinsics.width) & (a.v < of_blocks.model.intrinsics.height);
    luma[index] =
        view.color && inside ? squares[view.indexOf(a.u * of_blocks.reduction, a.v * of_blocks.reduction)] : -1.0f;
  }
};

/** \brief A step of a blur at one block. */
struct BlurLuma {
  BlockPointers blocks;
  const float* from;
  float* to;
  int du, dv;

  FUSE_FLOW_HD void operator()(std::uint32_t index) const {
    const PixelAddress a = blocks.grid.addressOf(index);
    const DeviceView& view = blocks.grid.views[a.view];
    to[index] = view.color && a.u < view.model.intrinsics.width
                    ? blurredLuma(blocks.of(view), from + view.offset, a.u, a.v, du, dv)
                    : -1.0f;
  }
};

}  // namespace gpu
}  // namespace fuse_flow
