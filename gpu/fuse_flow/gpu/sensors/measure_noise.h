#pragma once

#include <fuse_flow/gpu/runtime/execution.h>
#include <fuse_flow/gpu/sensors/noise_scale_kernel.h>

namespace fuse_flow {
namespace gpu {

/** \brief How noisy each view is, with the memory that it takes to find out. */
class NoiseMeasurement {
 public:
  /** \brief Sets the noise scales of views. \param pixels of the grid, padding included  \param z their depth, metres */
  void measure(Execution& run, const PixelGrid& grid, DeviceView* views, std::size_t pixels,
               const ConfidenceParameters& confidence, const float* z) {
    const std::size_t n = grid.view_count;
    counts_.resize(n * kNoiseBins);
    scales_.resize(n);
    fetched_.resize(n);
    run.fill(counts_.data(), n * kNoiseBins, 0);
    const CountNoise count{grid, z, counts_.data()};
    const MeasureNoise measure{{confidence, views, scales_.data()}, counts_.data()};
#if FUSE_FLOW_CUDA
    (void)pixels;
    const auto blocks = static_cast<unsigned int>(n);
    run.launch("countNoiseKernel", countNoiseKernel, dim3(kNoiseBlocks, blocks), kNoiseThreads, count);
    run.launch("measureNoiseKernel", measureNoiseKernel, blocks, kNoiseThreads, measure);
#else
    run.forEach(pixels / kChunk, count);
    run.forEach(n, measure);
#endif
    run.copySmall(fetched_.data(), scales_.data(), n);
  }

  /** \brief View by view, once the stream has been waited for. */
  const float* scales() const { return fetched_.data(); }

  std::size_t bytes() const { return counts_.bytes() + scales_.bytes(); }

 private:
  DeviceBuffer<std::uint32_t> counts_;
  DeviceBuffer<float> scales_;
  PinnedBuffer<float> fetched_;
};

}  // namespace gpu
}  // namespace fuse_flow
