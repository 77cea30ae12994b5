#pragma once

#include <fuse_flow/gpu/runtime/execution.h>
#include <fuse_flow/gpu/sensors/device_view.h>
#include <fuse_flow/math/depth.h>
#include <fuse_flow/sensors/depth_out_of_range.h>
#include <fuse_flow/sensors/preprocessing.h>

#include <cfloat>
#include <cstring>

namespace fuse_flow {
namespace gpu {

/** \brief What one view measures, in range or not. */
struct MeasureRange {
  /** \brief The bits of floats that are not negative are in their order. */
  struct Result {
    std::uint32_t measured;
    std::uint32_t in_range;
    std::uint32_t nearest;       ///< bits
    std::uint32_t not_farthest;  ///< complement of the bits, so that the largest depth is a minimum too
  };

  PixelGrid grid;
  std::uint32_t view;
  PreprocessingParameters range;
  Result* result;

  FUSE_FLOW_HD void operator()(std::uint32_t pixel) const {
    const DeviceView& of = grid.views[view];
    const auto width = static_cast<std::uint32_t>(of.model.intrinsics.width);
    const int u = static_cast<int>(pixel % width), v = static_cast<int>(pixel / width);
    float any, in_range;
    if (of.depth16) {
      const std::uint16_t raw = of.depth16.row(v)[u];
      any = metres(raw, of.depth_scale, 0.0f, FLT_MAX);
      in_range = metres(raw, of.depth_scale, range.min_range, range.max_range);
    } else {
      const float raw = of.depth32.row(v)[u];
      any = metres(raw, 0.0f, FLT_MAX);
      in_range = metres(raw, range.min_range, range.max_range);
    }
    if (!(any > 0)) return;
    std::uint32_t bits;
    memcpy(&bits, &any, sizeof bits);
    atomicAddTo(&result->measured, 1u);
    if (in_range > 0) atomicAddTo(&result->in_range, 1u);
    atomicMinTo(&result->nearest, bits);
    atomicMinTo(&result->not_farthest, ~bits);
  }
};

/** \brief The same, with the memory that it takes. Waits for the stream. */
class RangeMeasurement {
 public:
  DepthOutOfRange measure(Execution& run, const PixelGrid& grid, std::size_t view, const Intrinsics& K,
                          const PreprocessingParameters& range) {
    device_.resize(1);
    host_.resize(1);
    run.fill(device_.data(), 1, 0xff);
    run.fill(&device_.data()->measured, 2, 0);
    run.forEach(static_cast<std::size_t>(K.width) * static_cast<std::size_t>(K.height),
                MeasureRange{grid, static_cast<std::uint32_t>(view), range, device_.data()});
    run.copy(host_.data(), std::as_const(device_).data(), 1);
    run.wait();
    const MeasureRange::Result& found = *host_.data();
    DepthOutOfRange result;
    result.camera = view;
    result.measured = found.measured;
    result.in_range = found.in_range;
    if (found.measured == 0) return result;
    const std::uint32_t farthest = ~found.not_farthest;
    std::memcpy(&result.nearest, &found.nearest, sizeof result.nearest);
    std::memcpy(&result.farthest, &farthest, sizeof result.farthest);
    return result;
  }

 private:
  DeviceBuffer<MeasureRange::Result> device_;
  PinnedBuffer<MeasureRange::Result> host_;
};

}  // namespace gpu
}  // namespace fuse_flow
