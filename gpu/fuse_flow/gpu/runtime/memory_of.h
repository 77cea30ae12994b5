#pragma once

#include <fuse_flow/gpu/runtime/system.h>

namespace fuse_flow {
namespace gpu {

/** \brief Where memory is, as far as an upload cares. */
enum class Memory { Pageable, Pinned, Device };

inline Memory memoryOf(const void* data) {
#if FUSE_FLOW_CUDA
  cudaPointerAttributes attributes{};
  if (cudaPointerGetAttributes(&attributes, data) != cudaSuccess) {
    (void)cudaGetLastError();
    return Memory::Pageable;
  }
  if (attributes.type == cudaMemoryTypeDevice || attributes.type == cudaMemoryTypeManaged) return Memory::Device;
  return attributes.type == cudaMemoryTypeHost ? Memory::Pinned : Memory::Pageable;
#else
  (void)data;
  return Memory::Device;  // the device is the CPU
#endif
}

}  // namespace gpu
}  // namespace fuse_flow
