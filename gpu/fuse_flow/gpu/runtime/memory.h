#pragma once

#include <fuse_flow/gpu/runtime/system.h>

#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <new>
#include <utility>
#include <vector>

namespace fuse_flow {
namespace gpu {

/** \brief How often the process has asked for device or pinned memory; a warm frame does not. */
inline std::atomic<std::size_t>& memoryRequests() {
  static std::atomic<std::size_t> requests{0};
  return requests;
}

inline void* allocateDevice(std::size_t bytes) {
  memoryRequests().fetch_add(1, std::memory_order_relaxed);
#if FUSE_FLOW_CUDA
  void* memory = nullptr;
  const cudaError_t error = cudaMalloc(&memory, bytes);
  if (error == cudaErrorMemoryAllocation) {
    (void)cudaGetLastError();
    std::size_t free_bytes = 0, total = 0;
    (void)cudaMemGetInfo(&free_bytes, &total);
    throw DeviceError("fuse_flow::gpu: out of GPU memory: " + std::to_string(bytes >> 20) + " MiB more asked for, " +
                      std::to_string(free_bytes >> 20) + " of " + std::to_string(total >> 20) + " MiB are free");
  }
  check(error, "cudaMalloc");
  return memory;
#else
  return ::operator new (bytes, std::align_val_t{256});
#endif
}

inline void freeDevice(void* memory) noexcept {
#if FUSE_FLOW_CUDA
  if (memory) (void)cudaFree(memory);
#else
  ::operator delete (memory, std::align_val_t{256});
#endif
}

/** \brief Host memory that the device's copy engine reaches by itself. */
inline void* allocatePinned(std::size_t bytes) {
  memoryRequests().fetch_add(1, std::memory_order_relaxed);
#if FUSE_FLOW_CUDA
  void* memory = nullptr;
  check(cudaHostAlloc(&memory, bytes, cudaHostAllocDefault), "cudaHostAlloc");
  return memory;
#else
  return ::operator new (bytes, std::align_val_t{256});
#endif
}

inline void freePinned(void* memory) noexcept {
#if FUSE_FLOW_CUDA
  if (memory) (void)cudaFreeHost(memory);
#else
  ::operator delete (memory, std::align_val_t{256});
#endif
}

/** \brief Memory that grows and never shrinks; its contents are lost when it grows. */
template <typename Value, void* (*allocate)(std::size_t), void (*release)(void*) noexcept>
class Buffer {
 public:
  Buffer() = default;
  ~Buffer() { release(data_); }
  Buffer(Buffer&& other) noexcept
      : data_(std::exchange(other.data_, nullptr)), capacity_(std::exchange(other.capacity_, 0)) {}
  Buffer& operator=(Buffer&& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(capacity_, other.capacity_);
    return *this;
  }

  /** \brief An eighth more than asked for, so that frames of slightly different size need no new memory. */
  void resize(std::size_t n) {
    if (n <= capacity_) return;
    release(std::exchange(data_, nullptr));
    capacity_ = 0;
    const std::size_t wanted = n + n / 8 + 64;
    data_ = static_cast<Value*>(allocate(wanted * sizeof(Value)));
    capacity_ = wanted;
  }

  Value* data() { return data_; }
  const Value* data() const { return data_; }
  std::size_t capacity() const { return capacity_; }
  std::size_t bytes() const { return capacity_ * sizeof(Value); }

 private:
  Value* data_{nullptr};
  std::size_t capacity_{0};
};

template <typename Value>
using DeviceBuffer = Buffer<Value, allocateDevice, freeDevice>;
template <typename Value>
using PinnedBuffer = Buffer<Value, allocatePinned, freePinned>;

/** \brief Scratch memory of Thrust's and CUB's algorithms. What one call gives back, the next takes: work on one stream
 *  runs in order. */
class ScratchAllocator {
 public:
  using value_type = char;

  ScratchAllocator() = default;
  ScratchAllocator(const ScratchAllocator&) = delete;
  ~ScratchAllocator() {
    for (const Block& block : blocks_) freeDevice(block.memory);
  }

  char* allocate(std::ptrdiff_t bytes) {
    const auto wanted = static_cast<std::size_t>(bytes);
    Block* best = nullptr;
    for (Block& block : blocks_)
      if (!block.used && block.size >= wanted && (!best || block.size < best->size)) best = &block;
    if (!best) {
      const std::size_t size = wanted + wanted / 4 + 4096;
      blocks_.push_back({static_cast<char*>(allocateDevice(size)), size, false});
      best = &blocks_.back();
    }
    best->used = true;
    return best->memory;
  }

  void deallocate(char* memory, std::size_t) {
    for (Block& block : blocks_)
      if (block.memory == memory) block.used = false;
  }

  std::size_t bytes() const {
    std::size_t sum = 0;
    for (const Block& block : blocks_) sum += block.size;
    return sum;
  }

 private:
  struct Block {
    char* memory;
    std::size_t size;
    bool used;
  };
  std::vector<Block> blocks_;
};

}  // namespace gpu
}  // namespace fuse_flow
