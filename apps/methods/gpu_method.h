#pragma once

#include "methods/method.h"

namespace fuse_flow::io {

/** \brief Whether --device, "cpu", "gpu" or "auto", means the GPU. Throws OptionError, beginning with --device gpu, if that is asked
 *  for and this build has no CUDA, or there is no GPU. */
bool runsOnGpu(const std::string& device);

/** \brief Ours on the GPU, where runsOnGpu(). Throws DeviceError. */
std::unique_ptr<Method> makeGpuFusion(const MethodOptions& options);

}  // namespace fuse_flow::io
