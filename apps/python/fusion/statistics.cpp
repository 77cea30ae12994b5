#include "../bindings.h"
#include "../plain.h"

#include <fuse_flow/fusion/statistics.h>

#include <pybind11/stl.h>

namespace fuse_flow::python {

void bindStatistics(pybind11::module_& module) {
  named<DepthOutOfRange>(module, "DepthOutOfRange")
      .FUSE_FLOW_RESULT(DepthOutOfRange, camera)
      .FUSE_FLOW_RESULT(DepthOutOfRange, measured)
      .FUSE_FLOW_RESULT(DepthOutOfRange, in_range)
      .FUSE_FLOW_RESULT(DepthOutOfRange, nearest)
      .FUSE_FLOW_RESULT(DepthOutOfRange, farthest);

  named<FrameStatistics>(module, "FrameStatistics")
      .FUSE_FLOW_RESULT(FrameStatistics, measured_points)
      .FUSE_FLOW_RESULT(FrameStatistics, gated_points)
      .FUSE_FLOW_RESULT(FrameStatistics, coarse_cells)
      .FUSE_FLOW_RESULT(FrameStatistics, fused_points)
      .FUSE_FLOW_RESULT(FrameStatistics, missing_cameras)
      .FUSE_FLOW_RESULT(FrameStatistics, out_of_range)
      .FUSE_FLOW_RESULT(FrameStatistics, noise_scales)
      .FUSE_FLOW_RESULT(FrameStatistics, preprocess_ms)
      .FUSE_FLOW_RESULT(FrameStatistics, generate_ms)
      .FUSE_FLOW_RESULT(FrameStatistics, merge_ms)
      .FUSE_FLOW_RESULT(FrameStatistics, fuse_ms)
      .FUSE_FLOW_RESULT(FrameStatistics, output_ms)
      .FUSE_FLOW_RESULT(FrameStatistics, total_ms);
}

}  // namespace fuse_flow::python
