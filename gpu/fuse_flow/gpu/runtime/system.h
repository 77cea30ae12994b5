#pragma once

/** \file
 *  \brief The one place that knows what the device is: CUDA under nvcc, else Thrust's OpenMP, TBB or sequential system. */

#if !defined(__CUDACC__) && !defined(THRUST_DEVICE_SYSTEM)
#if defined(_OPENMP)
#define THRUST_DEVICE_SYSTEM THRUST_DEVICE_SYSTEM_OMP
#else
#define THRUST_DEVICE_SYSTEM THRUST_DEVICE_SYSTEM_CPP
#endif
#endif

#include <thrust/execution_policy.h>
#include <thrust/for_each.h>
#include <thrust/iterator/counting_iterator.h>
#include <thrust/version.h>

#if defined(__CUDACC__) && THRUST_DEVICE_SYSTEM == THRUST_DEVICE_SYSTEM_CUDA
#define FUSE_FLOW_CUDA 1
#include <cuda_runtime.h>
#if defined(__linux__)
#include <dlfcn.h>
#endif
#else
#define FUSE_FLOW_CUDA 0
#endif

#include <fuse_flow/device_error.h>
#include <fuse_flow/math/host_device.h>

#include <cstdint>
#include <string>

namespace fuse_flow {
namespace gpu {

#if FUSE_FLOW_CUDA
using Stream = cudaStream_t;

/** \brief Throws DeviceError with CUDA's own words. */
inline void check(cudaError_t error, const char* what) {
  if (error == cudaSuccess) return;
  (void)cudaGetLastError();  // the error is reported; the next call starts afresh
  throw DeviceError(std::string("fuse_flow::gpu: ") + what + ": " + cudaGetErrorString(error));
}
#else
/** \brief The CPU systems run at once: there is nothing to wait for. */
struct HostStream {};
using Stream = HostStream*;
#endif

/** \brief Whose work a device begins first, where streams compete. */
enum class StreamPriority { Usual, First };

/** \brief A stream that does not wait for the default one. */
class OwnStream {
 public:
#if FUSE_FLOW_CUDA
  explicit OwnStream(StreamPriority priority = StreamPriority::Usual) {
    int last = 0, first = 0;
    check(cudaDeviceGetStreamPriorityRange(&last, &first), "cudaDeviceGetStreamPriorityRange");
    check(
        cudaStreamCreateWithPriority(&stream_, cudaStreamNonBlocking, priority == StreamPriority::First ? first : last),
        "cudaStreamCreate");
  }
  ~OwnStream() { (void)cudaStreamDestroy(stream_); }
#else
  explicit OwnStream(StreamPriority = StreamPriority::Usual) {}
#endif
  OwnStream(const OwnStream&) = delete;
  Stream get() const { return stream_; }

 private:
  Stream stream_{};
};

/** \brief Puts the work of one stream before that of another. */
class StreamOrder {
 public:
#if FUSE_FLOW_CUDA
  StreamOrder() { check(cudaEventCreateWithFlags(&event_, cudaEventDisableTiming), "cudaEventCreate"); }
  ~StreamOrder() { (void)cudaEventDestroy(event_); }
#else
  StreamOrder() = default;
#endif
  StreamOrder(const StreamOrder&) = delete;

  /** \brief What comes to \p later from now on waits for what is on \p first by now; the host does not. */
  void put(Stream first, Stream later) {
#if FUSE_FLOW_CUDA
    check(cudaEventRecord(event_, first), "cudaEventRecord");
    check(cudaStreamWaitEvent(later, event_, 0), "cudaStreamWaitEvent");
#else
    (void)first;
    (void)later;
#endif
  }

#if FUSE_FLOW_CUDA
 private:
  cudaEvent_t event_{};
#endif
};

/** \brief Why there is no device to run on, with CUDA's own words; empty: there is one. */
inline std::string missingDevice() {
#if FUSE_FLOW_CUDA
#if defined(__linux__)
  // Where a driver's library is installed but no device is there, CUDA 12.0's runtime unloads the library under the feet of a thread
  // that the library has started: now it stays.
  static void* const driver = dlopen("libcuda.so.1", RTLD_NOW | RTLD_NODELETE);
  (void)driver;
#endif
  int count = 0;
  const cudaError_t error = cudaGetDeviceCount(&count);
  (void)cudaGetLastError();
  if (error == cudaSuccess && count > 0) return {};
  return std::string("no GPU found: ") + cudaGetErrorString(error == cudaSuccess ? cudaErrorNoDevice : error);
#else
  return {};
#endif
}

/** \brief Whether there is a device to run on. */
inline bool deviceAvailable() { return missingDevice().empty(); }

/** \brief The device that is current where an object is made: the one that its memory is on. */
class HomeDevice {
 public:
  /** \brief Throws DeviceError in its owner's name if there is no device. */
  explicit HomeDevice(const char* owner) {
    const std::string missing = missingDevice();
    if (!missing.empty()) throw DeviceError(std::string(owner) + ": " + missing);
#if FUSE_FLOW_CUDA
    check(cudaGetDevice(&device_), "cudaGetDevice");
#endif
  }

  /** \brief Makes it the current device of a thread of one's own, for good: a visit would go back to the first device, and take memory there. */
  void stay() const noexcept {
#if FUSE_FLOW_CUDA
    (void)cudaSetDevice(device_);
#endif
  }

  /** \brief Makes it the calling thread's current device, for as long as this lives. */
  class Visit {
   public:
#if FUSE_FLOW_CUDA
    explicit Visit(const HomeDevice& home) {
      check(cudaGetDevice(&before_), "cudaGetDevice");
      away_ = before_ != home.device_;
      if (away_) check(cudaSetDevice(home.device_), "cudaSetDevice");
    }
    ~Visit() {
      if (away_) (void)cudaSetDevice(before_);
    }
#else
    explicit Visit(const HomeDevice&) {}
    ~Visit() {}
#endif
    Visit(const Visit&) = delete;

   private:
#if FUSE_FLOW_CUDA
    int before_{0};
    bool away_{false};
#endif
  };

 private:
#if FUSE_FLOW_CUDA
  int device_{0};
#endif
};

// Integer atomics that both sides have. All of them are relaxed, and none decides an order that a result depends on.

template <typename Value>
FUSE_FLOW_HD Value atomicAddTo(Value* where, Value value) {
#if defined(__CUDA_ARCH__)
  return atomicAdd(where, value);
#else
  return __atomic_fetch_add(where, value, __ATOMIC_RELAXED);
#endif
}

FUSE_FLOW_HD void atomicMinTo(std::uint32_t* where, std::uint32_t value) {
#if defined(__CUDA_ARCH__)
  atomicMin(where, value);
#else
  std::uint32_t seen = __atomic_load_n(where, __ATOMIC_RELAXED);
  while (value < seen && !__atomic_compare_exchange_n(where, &seen, value, true, __ATOMIC_RELAXED, __ATOMIC_RELAXED)) {
  }
#endif
}

FUSE_FLOW_HD void atomicOrTo(std::uint32_t* where, std::uint32_t bits) {
#if defined(__CUDA_ARCH__)
  atomicOr(where, bits);
#else
  __atomic_fetch_or(where, bits, __ATOMIC_RELAXED);
#endif
}

FUSE_FLOW_HD std::uint32_t countBits(std::uint32_t bits) {
#if defined(__CUDA_ARCH__)
  return static_cast<std::uint32_t>(__popc(bits));
#else
  return static_cast<std::uint32_t>(__builtin_popcount(bits));
#endif
}

/** \brief Puts value where expected is, and returns what was there. */
FUSE_FLOW_HD std::uint64_t atomicExchangeIf(std::uint64_t* where, std::uint64_t expected, std::uint64_t value) {
#if defined(__CUDA_ARCH__)
  return atomicCAS(reinterpret_cast<unsigned long long*>(where), static_cast<unsigned long long>(expected),
                   static_cast<unsigned long long>(value));
#else
  __atomic_compare_exchange_n(where, &expected, value, false, __ATOMIC_RELAXED, __ATOMIC_RELAXED);
  return expected;
#endif
}

template <typename Value>
FUSE_FLOW_HD Value atomicLoad(const Value* where) {
#if defined(__CUDA_ARCH__)
  return *reinterpret_cast<const volatile Value*>(where);
#else
  return __atomic_load_n(where, __ATOMIC_RELAXED);
#endif
}

}  // namespace gpu
}  // namespace fuse_flow
