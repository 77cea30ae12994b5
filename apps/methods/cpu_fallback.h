#pragma once

#include "methods/method.h"

#include <functional>
#include <memory>
#include <string>

namespace fuse_flow::io {

/** \brief Fuses on the GPU until that fails, and on the CPU from that frame on: where nobody has asked for one of them, a GPU that runs out of
 *  memory, or is lost, costs speed and no frame. No method keeps anything of earlier frames, so no frame shows where it was. */
class CpuFallback : public Method {
 public:
  using Make = std::function<std::unique_ptr<Method>()>;
  using Warn = std::function<void(const std::string&)>;

  /** \param make_gpu may throw DeviceError  \param warn gets one line when the GPU has failed */
  CpuFallback(const Make& make_gpu, Make make_cpu, Warn warn);

  void fuse(const RigFrame& frame, Cloud& output) override;
  std::shared_ptr<const stream::EncodedFrame> fuseEncoded(const RigFrame& frame,
                                                          const stream::FrameTimes& times) override;
  const FrameStatistics& statistics() const override { return method_ ? method_->statistics() : statistics_; }
  const pcl::PointCloud<PointFusedNormal>& withNormals() const override {
    return method_ ? method_->withNormals() : with_normals_;
  }

 private:
  void goOnWithoutGpu(const std::string& error);

  Make make_cpu_;
  Warn warn_;
  std::unique_ptr<Method> method_;
  bool on_gpu_{true};
};

}  // namespace fuse_flow::io
