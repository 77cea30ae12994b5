#pragma once

/** \file
 *  \brief Where a filter runs. Every class of the library takes one of these tags as its last template parameter. */

namespace fuse_flow {
namespace device {

/** \brief The CPU, on as many threads as the class is told to use. */
struct Host {};

}  // namespace device
}  // namespace fuse_flow
