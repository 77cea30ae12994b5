#pragma once

#include <fuse_flow/gpu/counters.h>
#include <fuse_flow/gpu/fuse_children.h>
#include <fuse_flow/gpu/stage_times.h>

namespace fuse_flow {
namespace gpu {

/** \brief Whether a fused point stays. */
struct Stays {
  const std::uint8_t* states;
  FUSE_FLOW_HD bool operator()(std::uint32_t k) const { return states[k] == Kept; }
};

/** \brief Fused points with what becomes of them, and the list of those that stay. */
struct FusedPoints {
  DeviceBuffer<FusedPoint> fused;
  /** \brief ω, and a PointState. */
  DeviceBuffer<float> weights;
  DeviceBuffer<std::uint8_t> states;
  /** \brief Numbers of those that stay, ascending. */
  DeviceBuffer<std::uint32_t> staying;

  void resize(std::size_t n) {
    fused.resize(n);
    weights.resize(n);
    states.resize(n);
    staying.resize(n + 1);
  }

  /** \brief Returns how many of n stay. */
  std::size_t compact(Execution& run, StageTimes& times, CounterBuffer& counters, std::size_t n) {
    run.select(n, Stays{states.data()}, staying.data(), &counters.device(run)->fused);
    times.mark("compaction");
    const std::size_t count = counters.read(run).fused;
    times.setBytes("compaction", static_cast<double>(n) + 4.0 * static_cast<double>(count));
    return count;
  }

  std::size_t bytes() const { return fused.bytes() + weights.bytes() + states.bytes() + staying.bytes(); }
};

}  // namespace gpu
}  // namespace fuse_flow
