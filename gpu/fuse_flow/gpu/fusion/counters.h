#pragma once

#include <fuse_flow/gpu/fusion/generate_points.h>
#include <fuse_flow/gpu/runtime/execution.h>

namespace fuse_flow {
namespace gpu {

/** \brief What is counted on the device and the host must know: how much memory the next step needs. */
struct Counters {
  PointCounts points;
  std::uint32_t cells;
  std::uint32_t table_too_full;
  std::uint32_t runs;
  std::uint32_t children;
  std::uint32_t fused;
  std::uint64_t child_numbers;
};

/** \brief Counters on the device, and where the host reads them. */
class CounterBuffer {
 public:
  Counters* device(Execution& run) {
    if (device_.capacity() == 0) {
      host_.resize(1);
      device_.resize(1);  // last: either may find no memory
      run.fill(device_.data(), 1, 0);
    }
    return device_.data();
  }

  /** \brief Has them copied to host(), once the stream has been waited for. */
  void fetch(Execution& run) { run.copySmall(host_.data(), device(run), 1); }
  /** \brief Waits for all that has been started. */
  const Counters& read(Execution& run) {
    fetch(run);
    run.wait();
    return host();
  }
  /** \brief What was read last. */
  const Counters& host() const { return host_.data()[0]; }

 private:
  DeviceBuffer<Counters> device_;
  PinnedBuffer<Counters> host_;
};

}  // namespace gpu
}  // namespace fuse_flow
