#pragma once

#include <string>

namespace fuse_flow::io {

/** \brief The GPUs that --device gpu can run on, with the versions of CUDA; or why there is none. In one line. */
std::string gpuReport();

}  // namespace fuse_flow::io
