#pragma once

#include <fuse_flow/gpu/runtime/system.h>
#include <fuse_flow/math/confidence.h>
#include <fuse_flow/math/depth_correction.h>
#include <fuse_flow/math/view.h>

#include <cstddef>

namespace fuse_flow {
namespace gpu {

/** \brief Pixels that one warp works on: consecutive, and of one row. */
constexpr std::uint32_t kChunk = 32;

/** \brief One camera and what it measured, as the device sees it: plain pointers to device memory. */
struct DeviceView {
  ViewModel model;
  /** \brief unproject() of every pixel; null for an ideal lens. */
  const Ray* rays{nullptr};
  /** \brief Of the depth of every pixel; null where it is right. */
  const DepthCorrectionTerms* corrections{nullptr};
  /** \brief The other cameras that are present, nearest first. */
  const std::uint32_t* neighbours{nullptr};
  std::uint32_t neighbour_count{0};
  SlopeScale slope{};
  /** \brief Of its depth; the scale is measured on the device. */
  ViewNoise noise{};
  /** \brief Pixels of a block, each way, where the grid is one of blocks. */
  int reduction{1};

  ImageView<std::uint16_t> depth16;
  ImageView<float> depth32;
  ImageView<float> confidence;
  ImageView<Rgb8> color;
  /** \brief Of a colour camera of its own; without cells elsewhere. */
  ColorDepth color_depth;
  float depth_scale{0};

  /** \brief Number of pixel (0, 0), and from row to row: multiples of kChunk. */
  std::uint32_t offset{0};
  std::uint32_t pitch{0};
  bool present{false};

  FUSE_FLOW_HD std::uint32_t indexOf(int u, int v) const {
    return offset + static_cast<std::uint32_t>(v) * pitch + static_cast<std::uint32_t>(u);
  }

  FUSE_FLOW_HD Ray ray(int u, int v) const {
    const Intrinsics& K = model.intrinsics;
    if (rays == nullptr) return {(static_cast<float>(u) - K.cx) / K.fx, (static_cast<float>(v) - K.cy) / K.fy};
    return rays[static_cast<std::size_t>(v) * static_cast<std::size_t>(K.width) + static_cast<std::size_t>(u)];
  }
};

/** \brief Where a pixel's number points to. */
struct PixelAddress {
  std::uint32_t view;
  int u, v;
};

/** \brief The number of the last of some ascending numbers, the first of them 0, that is at most a given one. */
FUSE_FLOW_HD std::uint32_t lastUpTo(const std::uint32_t* numbers, std::uint32_t count, std::uint32_t value) {
  std::uint32_t low = 0, high = count;  // numbers[low] ≤ value < numbers[high]
  while (high - low > 1) {
    const std::uint32_t middle = (low + high) / 2;
    if (numbers[middle] <= value) {
      low = middle;
    } else {
      high = middle;
    }
  }
  return low;
}

/** \brief The pixels of all views, numbered view by view, row by row. Rows are padded to whole chunks, so that a chunk never
 *  crosses rows; the order of the numbers is that of the pixels. */
struct PixelGrid {
  const DeviceView* views;
  /** \brief Of every view, and the end. */
  const std::uint32_t* offsets;
  std::uint32_t view_count;

  FUSE_FLOW_HD std::uint32_t viewOf(std::uint32_t index) const { return lastUpTo(offsets, view_count, index); }

  FUSE_FLOW_HD PixelAddress addressOf(std::uint32_t index) const {
    const std::uint32_t i = viewOf(index);
    const std::uint32_t local = index - views[i].offset;
    const std::uint32_t v = local / views[i].pitch;
    return {i, static_cast<int>(local - v * views[i].pitch), static_cast<int>(v)};
  }
};

/** \brief A depth map of all views, metres, 0 where there is no measurement; of one view with a border of zeros. */
struct DepthMapOfView {
  const DeviceView* view;
  const float* z;

  FUSE_FLOW_HD float depth(int u, int v) const {
    const Intrinsics& K = view->model.intrinsics;
    const bool inside = (u >= 0) & (v >= 0) & (u < K.width) & (v < K.height);
    return inside ? z[view->indexOf(u, v)] : 0.0f;
  }
  FUSE_FLOW_HD Ray ray(int u, int v) const { return view->ray(u, v); }
};

/** \brief The 3×3 pixels at a spacing around one, row by row; zeros beyond the image. \param index number of the pixel */
FUSE_FLOW_HD void readPatch(const DepthMapOfView& map, int u, int v, std::uint32_t index, int step, float (&patch)[9]) {
  const Intrinsics& K = map.view->model.intrinsics;
  if ((u >= step) & (v >= step) & (u < K.width - step) & (v < K.height - step)) {
    const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(step) * map.view->pitch;
    const float* here = map.z + index;
    for (int k = 0; k < 3; ++k) {
      patch[k] = here[(k - 1) * step - row];
      patch[3 + k] = here[(k - 1) * step];
      patch[6 + k] = here[(k - 1) * step + row];
    }
  } else {
    for (int k = 0; k < 9; ++k) patch[k] = map.depth(u + (k % 3 - 1) * step, v + (k / 3 - 1) * step);
  }
}

}  // namespace gpu
}  // namespace fuse_flow
