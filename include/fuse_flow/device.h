#pragma once

/** \file
 *  \brief Where a filter runs. Every class of the library takes one of these tags as its last template parameter. */

namespace fuse_flow {
namespace device {

/** \brief The CPU, on as many threads as the class is told to use. */
struct Host {};

/** \brief Thrust: CUDA where nvcc compiles; TBB, OpenMP or one CPU thread, as THRUST_DEVICE_SYSTEM says, where another
 *  compiler does. Include a header of fuse_flow/gpu/ to have the classes for it. */
struct Thrust {};

}  // namespace device
}  // namespace fuse_flow
