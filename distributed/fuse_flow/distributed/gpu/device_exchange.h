#pragma once

#include <fuse_flow/gpu/runtime/execution.h>

#include <vector>

namespace fuse_flow {
namespace distributed {

/** \brief Bytes in device memory that go to another rank, or come from it. */
struct DeviceMessage {
  int rank;           ///< the other
  char* data;         ///< in device memory
  std::size_t bytes;  ///< how many
};

/** \brief How the large part of a frame gets from the memory of one device to that of another. */
class DeviceExchange {
 public:
  virtual ~DeviceExchange() = default;

  /** \brief What is launched on the stream afterwards finds the received bytes; what was launched before has been sent. All ranks call this equally
   *  often, with what the others receive and send.
   *  \param sends at most one message a rank, none of them empty  \param receives likewise */
  virtual void exchange(gpu::Execution& run, const std::vector<DeviceMessage>& sends,
                        const std::vector<DeviceMessage>& receives) = 0;
};

}  // namespace distributed
}  // namespace fuse_flow
