#include "stereo/depth_estimation.h"

#include "methods/gpu_method.h"
#include "methods/gpu_then_cpu.h"
#include "stereo/gpu_stereo.h"

namespace fuse_flow::io {
namespace {

class OnGpuThenCpu : public DepthEstimation {
 public:
  using Either = GpuThenCpu<DepthEstimation>;

  OnGpuThenCpu(const Either::Make& gpu, Either::Make cpu, Either::Warn warn)
      : either_(gpu, std::move(cpu), std::move(warn)) {}
  void estimate(const RigFrame& frame, StereoFrame& result) override {
    either_.run([&](DepthEstimation& estimation) { estimation.estimate(frame, result); });
  }

 private:
  Either either_;
};

}  // namespace

std::unique_ptr<DepthEstimation> makeDepthEstimation(const StereoParameters& parameters, unsigned int threads,
                                                     const std::string& device,
                                                     const std::function<void(const std::string&)>& warn) {
  const auto on_cpu = [parameters, threads]() -> std::unique_ptr<DepthEstimation> {
    return std::make_unique<DepthEstimationOn<device::Host>>(parameters, threads);
  };
  if (!runsOnGpu(device)) return on_cpu();
  const auto on_gpu = [&] { return makeGpuDepthEstimation(parameters, threads); };
  if (device == "gpu" || !warn) return on_gpu();
  return std::make_unique<OnGpuThenCpu>(on_gpu, on_cpu, warn);
}

}  // namespace fuse_flow::io
