#pragma once

#include <fuse_flow/distributed/gpu/device_windows.h>
#include <fuse_flow/gpu/fusion/cell_table.h>
#include <fuse_flow/math/representatives.h>

namespace fuse_flow {
namespace distributed {

// One thread a pixel: those of neighbours read and write side by side, which is what memory is fast at.

/** \brief Writes a pixel of an own view into its message. */
struct PackWindows {
  WindowList list;
  const gpu::DeviceView* views;
  const float *measured, *refined;
  const WeightedPoint* points;
  const std::uint32_t* block_slots;  ///< of each pixel's point; kNone: no point
  const std::int32_t* owners;        ///< of each slot

  FUSE_FLOW_HD void operator()(std::uint32_t pixel) const {
    const WindowList::Place at = list.placeOf(pixel / kPixelGroup);
    const std::uint32_t in_group = pixel % kPixelGroup;
    const DeviceWindow& window = *at.window;
    const gpu::DeviceView& view = views[window.view];
    const std::uint32_t index = view.indexOf(at.u, at.v) + in_group;
    const std::size_t place = std::size_t{at.group} * kPixelGroup + in_group;
    window.depth[place] = measured[index];
    if (window.refined != nullptr) window.refined[place] = refined[index];
    const std::uint32_t slot = block_slots[index];
    const bool receivers = slot != gpu::CellTableView::kNone && owners[slot] == window.rank;
    window.weights[place] = receivers ? points[index].C : 0.0f;
    const int u = at.u + static_cast<int>(in_group);
    const bool there = u < view.model.intrinsics.width;  // and not in the padding of the rows
    if (window.confidence != nullptr) window.confidence[place] = there ? view.confidence.row(at.v)[u] : 0.0f;
    if (window.color != nullptr) window.color[place] = there ? view.color.row(at.v)[u] : Rgb8{};
  }
};

/** \brief Puts a pixel of another rank's view in the place of its number. */
struct UnpackWindows {
  WindowList list;
  const gpu::DeviceView* views;
  float *measured, *refined;  ///< the same where nothing is smoothed
  WeightedPoint* points;
  float* confidences;  ///< of all pixels; null: none
  Rgb8* colors;        ///< likewise

  FUSE_FLOW_HD void operator()(std::uint32_t pixel) const {
    const WindowList::Place at = list.placeOf(pixel / kPixelGroup);
    const std::uint32_t in_group = pixel % kPixelGroup;
    const DeviceWindow& window = *at.window;
    const gpu::DeviceView& view = views[window.view];
    const std::uint32_t index = view.indexOf(at.u, at.v) + in_group;
    const std::size_t place = std::size_t{at.group} * kPixelGroup + in_group;
    float depth = window.depth[place];
    measured[index] = depth;
    if (window.refined != nullptr) refined[index] = depth = window.refined[place];
    const float C = window.weights[place];
    WeightedPoint point{};
    if (C > 0)  // eq. 8, as GeneratePoints has it
      point = {view.model.T_world_camera * pointOnRay(view.ray(at.u + static_cast<int>(in_group), at.v), depth), C};
    points[index] = point;
    if (window.confidence != nullptr) confidences[index] = window.confidence[place];
    if (window.color != nullptr) colors[index] = window.color[place];
  }
};

}  // namespace distributed
}  // namespace fuse_flow
