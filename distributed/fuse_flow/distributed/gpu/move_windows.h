#pragma once

#include <fuse_flow/distributed/gpu/device_windows.h>
#include <fuse_flow/gpu/fusion/cell_table.h>
#include <fuse_flow/math/representatives.h>

namespace fuse_flow {
namespace distributed {

/** \brief Values of a group of pixels, moved 16 bytes at a time. */
struct alignas(16) GroupOfFloats {
  float value[kPixelGroup];
};
/** \brief Likewise; 24 bytes, which begin at multiples of 8. */
struct alignas(8) GroupOfColors {
  Rgb8 value[kPixelGroup];
};
static_assert(sizeof(GroupOfColors) == 3 * kPixelGroup, "without padding");

FUSE_FLOW_HD void moveGroup(const float* from, float* to) {
  *reinterpret_cast<GroupOfFloats*>(to) = *reinterpret_cast<const GroupOfFloats*>(from);
}
FUSE_FLOW_HD void moveGroup(const Rgb8* from, Rgb8* to) {
  *reinterpret_cast<GroupOfColors*>(to) = *reinterpret_cast<const GroupOfColors*>(from);
}

/** \brief Writes a group of pixels of an own view into its message. */
struct PackWindows {
  WindowList list;
  const gpu::DeviceView* views;
  const float *measured, *refined;
  const WeightedPoint* points;
  const std::uint32_t* block_slots;  ///< of each pixel's point; kNone: no point
  const std::int32_t* owners;        ///< of each slot

  FUSE_FLOW_HD void operator()(std::uint32_t group) const {
    const WindowList::Place at = list.placeOf(group);
    const DeviceWindow& window = *at.window;
    const gpu::DeviceView& view = views[window.view];
    const std::uint32_t index = view.indexOf(at.u, at.v);
    const std::size_t place = std::size_t{at.group} * kPixelGroup;
    moveGroup(measured + index, window.depth + place);
    if (window.refined != nullptr) moveGroup(refined + index, window.refined + place);
    GroupOfFloats weights;
    for (std::uint32_t k = 0; k < kPixelGroup; ++k) {
      const std::uint32_t slot = block_slots[index + k];
      const bool receivers = slot != gpu::CellTableView::kNone && owners[slot] == window.rank;
      weights.value[k] = receivers ? points[index + k].C : 0.0f;
    }
    moveGroup(weights.value, window.weights + place);
    if (window.confidence != nullptr) packImage(view, view.confidence, at, window.confidence + place);
    if (window.color != nullptr) packImage(view, view.color, at, window.color + place);
  }

 private:
  /** \brief The creator of the image says where its rows begin: no alignment is known. */
  template <typename Pixel>
  FUSE_FLOW_HD static void packImage(const gpu::DeviceView& view, const ImageView<Pixel>& image,
                                     const WindowList::Place& at, Pixel* to) {
    const Pixel* const from = image.row(at.v) + at.u;
    const int left = view.model.intrinsics.width - at.u;
    constexpr std::uintptr_t aligned = sizeof(Pixel) == sizeof(Rgb8) ? alignof(GroupOfColors) : alignof(GroupOfFloats);
    if (left >= static_cast<int>(kPixelGroup) && reinterpret_cast<std::uintptr_t>(from) % aligned == 0) {
      moveGroup(from, to);
      return;
    }
    for (int k = 0; k < static_cast<int>(kPixelGroup); ++k) to[k] = k < left ? from[k] : Pixel{};
  }
};

/** \brief Puts a group of pixels of another rank's view in the places of their numbers. */
struct UnpackWindows {
  WindowList list;
  const gpu::DeviceView* views;
  float *measured, *refined;  ///< the same where nothing is smoothed
  WeightedPoint* points;
  float* confidences;  ///< of all pixels; null: none
  Rgb8* colors;        ///< likewise

  FUSE_FLOW_HD void operator()(std::uint32_t group) const {
    const WindowList::Place at = list.placeOf(group);
    const DeviceWindow& window = *at.window;
    const gpu::DeviceView& view = views[window.view];
    const std::uint32_t index = view.indexOf(at.u, at.v);
    const std::size_t place = std::size_t{at.group} * kPixelGroup;
    moveGroup(window.depth + place, measured + index);
    if (window.refined != nullptr) moveGroup(window.refined + place, refined + index);
    const float* const depth = (window.refined != nullptr ? window.refined : window.depth) + place;
    for (std::uint32_t k = 0; k < kPixelGroup; ++k) {
      const float C = window.weights[place + k];
      WeightedPoint point{};
      if (C > 0)  // eq. 8, as GeneratePoints has it
        point = {view.model.T_world_camera * pointOnRay(view.ray(at.u + static_cast<int>(k), at.v), depth[k]), C};
      points[index + k] = point;
    }
    if (window.confidence != nullptr) moveGroup(window.confidence + place, confidences + index);
    if (window.color != nullptr) moveGroup(window.color + place, colors + index);
  }
};

}  // namespace distributed
}  // namespace fuse_flow
