// In place of gpu_fusion.cu where the module is built without CUDA.

#include "gpu_fusion.h"

#include <pcl/exceptions.h>

namespace fuse_flow::python {

std::unique_ptr<GpuFusion> makeGpuFusion(const PointExtras&) {
  throw pcl::PCLException("fuse_flow::FuseFlow: device='gpu': this build has no CUDA; build it where nvcc is");
}

}  // namespace fuse_flow::python
