#pragma once

/** \file
 *  \brief Where a filter runs. Every class of the library takes one of these tags as its last template parameter. */

namespace fuse_flow {
namespace device {

/** \brief The CPU, on as many threads as the class's setNumberOfThreads() sets. */
struct Host {};

/** \brief Thrust. If nvcc compiles: CUDA. If another compiler compiles: TBB, OpenMP or one CPU thread, as THRUST_DEVICE_SYSTEM selects. The
 *  headers in fuse_flow/gpu/ have the classes for it. */
struct Thrust {};

}  // namespace device
}  // namespace fuse_flow
