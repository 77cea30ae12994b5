#pragma once

#include <pcl/exceptions.h>

#include <string>

namespace fuse_flow {

/** \brief What the classes with device::Thrust throw where not the request is at fault: the device, its driver or its memory has failed, or
 *  there is no device. The object is as usable as before, and another attempt may succeed. After an error inside a kernel CUDA fails every
 *  later call of the process: then the CPU's classes go on, or another process. It is a pcl::PCLException, so that who catches that needs
 *  to know nothing of GPUs. */
class DeviceError : public pcl::PCLException {
 public:
  /** \param message what was done, and what the device's runtime says of it */
  explicit DeviceError(const std::string& message) : pcl::PCLException(message) {}
};

}  // namespace fuse_flow
