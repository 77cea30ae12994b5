#include "failing_cuda.h"

#include <cuda_runtime_api.h>
#include <dlfcn.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>

namespace failing_cuda {
namespace {

std::atomic<long> counted{0};
std::atomic<long> held{0};
std::atomic<long> failing_call{0};
std::atomic<int> failing_error{0};
std::atomic<bool> stays{false};
std::atomic<const char*> failed{nullptr};
/** \brief What cudaGetLastError() has yet to report of this thread: the stubs of kernels drop what a launch returns. */
thread_local cudaError_t pending = cudaSuccess;

void* realFunction(const char* name) {
  void* const function = dlsym(RTLD_NEXT, name);
  if (function != nullptr) return function;
  std::fprintf(stderr, "failing_cuda: the CUDA runtime has no %s\n", name);
  std::abort();
}

cudaError_t failing() { return static_cast<cudaError_t>(failing_error.load()); }

bool lost() { return stays && failed.load() != nullptr; }

/** \brief Whether this call fails. */
bool fails(const char* name) {
  const long call = ++counted, at = failing_call;
  if (at == 0 || (call != at && !(call > at && stays))) return false;
  const char* none = nullptr;
  failed.compare_exchange_strong(none, name);
  pending = failing();
  return true;
}

}  // namespace

void failAt(long call, int error, After after) {
  failing_call = 0;
  failed = nullptr;
  pending = cudaSuccess;
  failing_error = error;
  stays = after == After::SameError;
  counted = 0;
  failing_call = call;
}

long blocksHeld() { return held; }

std::string failedFunction() {
  const char* name = failed;
  return name == nullptr ? "" : name;
}

}  // namespace failing_cuda

// Each function in place of the runtime's: NAME, parameters, arguments.
#define FAILING(name, parameters, arguments)                                                \
  extern "C" cudaError_t CUDARTAPI name parameters {                                        \
    using Function = cudaError_t(CUDARTAPI*) parameters;                                    \
    static const auto real = reinterpret_cast<Function>(failing_cuda::realFunction(#name)); \
    return failing_cuda::fails(#name) ? failing_cuda::failing() : real arguments;           \
  }
// What frees is done, also where the device is lost.
#define FREEING(name, parameters, arguments)                                                \
  extern "C" cudaError_t CUDARTAPI name parameters {                                        \
    using Function = cudaError_t(CUDARTAPI*) parameters;                                    \
    static const auto real = reinterpret_cast<Function>(failing_cuda::realFunction(#name)); \
    const cudaError_t result = real arguments;                                              \
    if (!failing_cuda::lost()) return result;                                               \
    failing_cuda::pending = failing_cuda::failing();                                        \
    return failing_cuda::pending;                                                           \
  }
#define ALLOCATING(name, parameters, arguments)                                             \
  extern "C" cudaError_t CUDARTAPI name parameters {                                        \
    using Function = cudaError_t(CUDARTAPI*) parameters;                                    \
    static const auto real = reinterpret_cast<Function>(failing_cuda::realFunction(#name)); \
    if (failing_cuda::fails(#name)) return failing_cuda::failing();                         \
    const cudaError_t result = real arguments;                                              \
    if (result == cudaSuccess) ++failing_cuda::held;                                        \
    return result;                                                                          \
  }
#define FREEING_MEMORY(name)                                                                \
  extern "C" cudaError_t CUDARTAPI name(void* memory) {                                     \
    using Function = cudaError_t(CUDARTAPI*)(void*);                                        \
    static const auto real = reinterpret_cast<Function>(failing_cuda::realFunction(#name)); \
    const cudaError_t result = real(memory);                                                \
    if (memory != nullptr && result == cudaSuccess) --failing_cuda::held;                   \
    if (!failing_cuda::lost()) return result;                                               \
    failing_cuda::pending = failing_cuda::failing();                                        \
    return failing_cuda::pending;                                                           \
  }

FAILING(cudaMemcpyAsync, (void* to, const void* from, size_t size, cudaMemcpyKind kind, cudaStream_t stream),
        (to, from, size, kind, stream))
FAILING(cudaMemcpy2DAsync,
        (void* to, size_t to_pitch, const void* from, size_t from_pitch, size_t width, size_t height,
         cudaMemcpyKind kind, cudaStream_t stream),
        (to, to_pitch, from, from_pitch, width, height, kind, stream))
FAILING(cudaMemsetAsync, (void* memory, int value, size_t size, cudaStream_t stream), (memory, value, size, stream))
FAILING(cudaMemGetInfo, (size_t * free_bytes, size_t* total), (free_bytes, total))
FAILING(cudaPointerGetAttributes, (cudaPointerAttributes * attributes, const void* pointer), (attributes, pointer))
FAILING(cudaStreamCreateWithPriority, (cudaStream_t * stream, unsigned int flags, int priority),
        (stream, flags, priority))
FAILING(cudaStreamSynchronize, (cudaStream_t stream), (stream))
FAILING(cudaStreamWaitEvent, (cudaStream_t stream, cudaEvent_t event, unsigned int flags), (stream, event, flags))
FAILING(cudaStreamBeginCapture, (cudaStream_t stream, cudaStreamCaptureMode mode), (stream, mode))
FAILING(cudaEventCreateWithFlags, (cudaEvent_t * event, unsigned int flags), (event, flags))
FAILING(cudaEventRecord, (cudaEvent_t event, cudaStream_t stream), (event, stream))
FAILING(cudaGraphInstantiate, (cudaGraphExec_t * executable, cudaGraph_t graph, unsigned long long flags),
        (executable, graph, flags))
FAILING(cudaGraphLaunch, (cudaGraphExec_t executable, cudaStream_t stream), (executable, stream))
FAILING(cudaLaunchKernelExC, (const cudaLaunchConfig_t* config, const void* function, void** arguments),
        (config, function, arguments))
#if CUDART_VERSION >= 13000
FAILING(__cudaLaunchKernel,
        (cudaKernel_t kernel, dim3 grid, dim3 block, void** arguments, size_t shared, cudaStream_t stream),
        (kernel, grid, block, arguments, shared, stream))
#endif
FAILING(cudaLaunchKernel,
        (const void* kernel, dim3 grid, dim3 block, void** arguments, size_t shared, cudaStream_t stream),
        (kernel, grid, block, arguments, shared, stream))
FAILING(cudaFuncGetAttributes, (cudaFuncAttributes * attributes, const void* function), (attributes, function))
FAILING(cudaOccupancyMaxActiveBlocksPerMultiprocessorWithFlags,
        (int* blocks, const void* function, int threads, size_t shared, unsigned int flags),
        (blocks, function, threads, shared, flags))
FAILING(cudaDeviceGetStreamPriorityRange, (int* least, int* greatest), (least, greatest))
FAILING(cudaDeviceGetAttribute, (int* value, cudaDeviceAttr attribute, int device), (value, attribute, device))
FAILING(cudaGetDevice, (int* device), (device))
FAILING(cudaSetDevice, (int device), (device))
FAILING(cudaGetDeviceCount, (int* count), (count))

FREEING(cudaStreamDestroy, (cudaStream_t stream), (stream))
FREEING(cudaEventDestroy, (cudaEvent_t event), (event))
FREEING(cudaGraphDestroy, (cudaGraph_t graph), (graph))
FREEING(cudaGraphExecDestroy, (cudaGraphExec_t executable), (executable))

// Memory is counted, too.
ALLOCATING(cudaMalloc, (void** memory, size_t size), (memory, size))
ALLOCATING(cudaHostAlloc, (void** memory, size_t size, unsigned int flags), (memory, size, flags))
FREEING_MEMORY(cudaFree)
FREEING_MEMORY(cudaFreeHost)

// A capture ends, also where that fails.
extern "C" cudaError_t CUDARTAPI cudaStreamEndCapture(cudaStream_t stream, cudaGraph_t* graph) {
  static const auto real = reinterpret_cast<cudaError_t(CUDARTAPI*)(cudaStream_t, cudaGraph_t*)>(
      failing_cuda::realFunction("cudaStreamEndCapture"));
  const cudaError_t result = real(stream, graph);
  if (!failing_cuda::fails("cudaStreamEndCapture")) return result;
  if (*graph != nullptr) (void)cudaGraphDestroy(*graph);
  *graph = nullptr;
  return failing_cuda::failing();
}

extern "C" cudaError_t CUDARTAPI cudaPeekAtLastError() {
  static const auto real =
      reinterpret_cast<cudaError_t(CUDARTAPI*)()>(failing_cuda::realFunction("cudaPeekAtLastError"));
  return failing_cuda::pending != cudaSuccess ? failing_cuda::pending : real();
}

extern "C" cudaError_t CUDARTAPI cudaGetLastError() {
  static const auto real = reinterpret_cast<cudaError_t(CUDARTAPI*)()>(failing_cuda::realFunction("cudaGetLastError"));
  const cudaError_t error = real();
  if (failing_cuda::pending == cudaSuccess) return error;
  const cudaError_t reported = failing_cuda::pending;
  if (!failing_cuda::lost()) failing_cuda::pending = cudaSuccess;
  return reported;
}
