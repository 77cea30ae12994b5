#include "methods/gpu_report.h"

#include <fuse_flow/gpu/runtime/system.h>

namespace fuse_flow::io {
namespace {

/** \brief CUDA's number for a version, such as 12040, as people write it. */
std::string versionText(int version) {
  return version == 0 ? "none" : std::to_string(version / 1000) + "." + std::to_string(version % 1000 / 10);
}

}  // namespace

std::string gpuReport() {
  const std::string missing = gpu::missingDevice();
  int runtime = 0, driver = 0, count = 0;
  cudaRuntimeGetVersion(&runtime);
  cudaDriverGetVersion(&driver);
  std::string text = missing.empty() ? "" : "none: " + missing + "; ";
  if (missing.empty()) cudaGetDeviceCount(&count);
  for (int i = 0; i < count; ++i) {
    cudaDeviceProp device{};
    if (cudaGetDeviceProperties(&device, i) != cudaSuccess) continue;
    text += std::string(device.name) + ", compute capability " + std::to_string(device.major) + "." +
            std::to_string(device.minor) + ", " + std::to_string(device.totalGlobalMem >> 20) + " MiB; ";
  }
  (void)cudaGetLastError();
  return text + "CUDA " + versionText(runtime) + ", driver for CUDA " + versionText(driver);
}

}  // namespace fuse_flow::io
