#pragma once

#include "methods/gpu_then_cpu.h"
#include "methods/method.h"

#include <memory>

namespace fuse_flow::io {

/** \brief Fuses on the GPU until that fails, and on the CPU from that frame on, see GpuThenCpu. No method keeps anything of earlier frames, so no
 *  frame shows where it was. */
class CpuFallback : public Method {
 public:
  using Make = GpuThenCpu<Method>::Make;
  using Warn = GpuThenCpu<Method>::Warn;

  /** \copydoc GpuThenCpu::GpuThenCpu */
  CpuFallback(const Make& make_gpu, Make make_cpu, Warn warn);

  void fuse(const RigFrame& frame, Cloud& output) override;
  std::shared_ptr<const stream::EncodedFrame> fuseEncoded(const RigFrame& frame,
                                                          const stream::FrameTimes& times) override;
  const FrameStatistics& statistics() const override {
    return method_.worker() ? method_.worker()->statistics() : statistics_;
  }
  const pcl::PointCloud<PointFusedNormal>& withNormals() const override {
    return method_.worker() ? method_.worker()->withNormals() : with_normals_;
  }

 private:
  GpuThenCpu<Method> method_;
};

}  // namespace fuse_flow::io
