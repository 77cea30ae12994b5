#pragma once

#include <fuse_flow/gpu/fusion/counters.h>
#include <fuse_flow/gpu/fusion/fuse_children.h>
#include <fuse_flow/gpu/runtime/stage_times.h>
#include <fuse_flow/math/box.h>

namespace fuse_flow {
namespace gpu {

/** \brief Whether a fused point stays. */
struct Stays {
  const std::uint8_t* states;
  /** \brief Null, or the points, which must lie in the box. */
  const FusedPoint* fused;
  Box box;
  FUSE_FLOW_HD bool operator()(std::uint32_t k) const {
    return states[k] == Kept && (fused == nullptr || box.contains(fused[k].p));
  }
};

/** \brief What is asked for about the cameras that a fused point is from: their number, or which they are, too. */
enum class CamerasWanted { HowMany, Which };

/** \brief Fused points with what becomes of them, and the list of those that stay. */
struct FusedPoints {
  DeviceBuffer<FusedPoint> fused;
  /** \brief ω, and a PointState. */
  DeviceBuffer<float> weights;
  DeviceBuffer<std::uint8_t> states;
  /** \brief In place of FusedPoint::views: beside each other they are read and written faster. While children are fused, OtherCameras. */
  DeviceBuffer<std::uint32_t> view_counts;
  /** \brief PointCameras::mask(), where CamerasWanted::Which. */
  DeviceBuffer<std::uint64_t> cameras;
  /** \brief Numbers of those that stay, ascending. */
  DeviceBuffer<std::uint32_t> staying;

  void resize(std::size_t n, CamerasWanted wanted) {
    fused.resize(n);
    view_counts.resize(n);
    if (wanted == CamerasWanted::Which) cameras.resize(n);
    weights.resize(n);
    states.resize(n);
    staying.resize(n + 1);
  }

  /** \brief Returns how many of n stay. \param box null, or in which they must lie */
  std::size_t compact(Execution& run, StageTimes& times, CounterBuffer& counters, std::size_t n,
                      const Box* box = nullptr) {
    run.select(n, Stays{states.data(), box ? fused.data() : nullptr, box ? *box : Box()}, staying.data(),
               &counters.device(run)->fused);
    times.mark("compaction");
    const std::size_t count = counters.read(run).fused;
    times.setBytes("compaction", static_cast<double>(n) + 4.0 * static_cast<double>(count));
    return count;
  }

  std::size_t bytes() const {
    return fused.bytes() + weights.bytes() + states.bytes() + view_counts.bytes() + cameras.bytes() + staying.bytes();
  }
};

}  // namespace gpu
}  // namespace fuse_flow
