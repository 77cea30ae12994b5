#include "io/error.h"
#include "io/fusion_with_normals.h"
#include "io/gpu_method.h"

#include <fuse_flow/gpu/fuse_flow.h>

namespace fuse_flow::io {
namespace {

class GpuFusion : public Method {
 public:
  explicit GpuFusion(const MethodOptions& options) {
    fusion_.setParameters(options.parameters);
    fusion_.setNumberOfThreads(options.threads);
  }
  void fuse(const RigFrame& frame, Cloud& output) override {
    fusion_.fuse(frame, output);
    statistics_ = fusion_.getStatistics();
  }

 private:
  FuseFlow<PointFused, device::Thrust> fusion_;
};

}  // namespace

bool runsOnGpu(const std::string& device) {
  const bool found = device != "cpu" && gpu::deviceAvailable();
  if (device == "gpu" && !found) throw OptionError("--device gpu: no GPU found; use --device cpu");
  return found;
}

std::unique_ptr<Method> makeGpuFusion(const MethodOptions& options) {
  if (options.normals) return std::make_unique<FusionWithNormals<FuseFlow<PointFusedNormal, device::Thrust>>>(options);
  return std::make_unique<GpuFusion>(options);
}

}  // namespace fuse_flow::io
