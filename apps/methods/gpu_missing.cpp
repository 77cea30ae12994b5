// In place of gpu_method.cu, gpu_poses.cu, gpu_report.cu and gpu_stereo.cu where the tools are built without CUDA.

#include "calibration/gpu_poses.h"
#include "methods/gpu_method.h"
#include "methods/gpu_report.h"
#include "stereo/gpu_stereo.h"

#include <fuse_flow/recordings/error.h>

namespace fuse_flow::io {

bool runsOnGpu(const std::string& device) {
  if (device == "gpu")
    throw OptionError("--device gpu: this build has no CUDA; build it where nvcc is, or use --device cpu");
  return false;
}

std::string gpuReport() { return "none: this build has no CUDA"; }

// Nobody asks for what follows.
std::unique_ptr<Method> makeGpuFusion(const MethodOptions&) { return nullptr; }
std::unique_ptr<PoseEstimation> makeGpuPoseEstimation(const ExtrinsicParameters&, unsigned int) { return nullptr; }
std::unique_ptr<DepthEstimation> makeGpuDepthEstimation(const StereoParameters&, unsigned int) { return nullptr; }
std::unique_ptr<PoseTracking> makeGpuPoseTracking(const std::vector<Camera>&, double) { return nullptr; }

}  // namespace fuse_flow::io
