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
  if (device == "cpu") return false;
  const std::string missing = gpu::missingDevice();
  if (device == "gpu" && !missing.empty()) throw OptionError("--device gpu: " + missing + "; use --device cpu");
  return missing.empty();
}

std::unique_ptr<Method> makeGpuFusion(const MethodOptions& options) {
  if (options.normals) return std::make_unique<FusionWithNormals<FuseFlow<PointFusedNormal, device::Thrust>>>(options);
  return std::make_unique<GpuFusion>(options);
}

}  // namespace fuse_flow::io
