#pragma once

#include "io/method.h"

namespace fuse_flow::io {

/** \brief Whether this build can use a GPU, and one is there. */
bool gpuFound();

/** \brief Ours on the GPU. Throws OptionError, beginning with --device gpu, if this build has no CUDA or there is no GPU. */
std::unique_ptr<Method> makeGpuFusion(const MethodOptions& options);

}  // namespace fuse_flow::io
