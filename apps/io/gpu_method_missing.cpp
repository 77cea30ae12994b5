// In place of gpu_method.cu where the tools are built without CUDA.

#include "io/error.h"
#include "io/gpu_method.h"

namespace fuse_flow::io {

bool gpuFound() { return false; }

std::unique_ptr<Method> makeGpuFusion(const MethodOptions&) {
  throw OptionError("--device gpu: this build has no CUDA; build it where nvcc is, or use --device cpu");
}

}  // namespace fuse_flow::io
