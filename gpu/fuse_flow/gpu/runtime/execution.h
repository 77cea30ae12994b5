#pragma once

#include <fuse_flow/gpu/runtime/memory.h>
#include <fuse_flow/gpu/runtime/value_bytes.h>

#include <thrust/copy.h>
#include <thrust/scan.h>
#include <thrust/sort.h>
#include <thrust/system_error.h>

#if FUSE_FLOW_CUDA
#include <cub/cub.cuh>
#endif

#include <cstring>
#include <vector>

namespace fuse_flow {
namespace gpu {

/** \brief Copies words from anywhere to anywhere that the device reaches. */
struct CopyWords {
  std::uint32_t* to;
  const std::uint32_t* from;
  FUSE_FLOW_HD void operator()(std::uint32_t k) const { to[k] = from[k]; }
};

/** \brief Where the steps of a frame run: a stream, and the scratch memory of the algorithms. The functions return at once on
 *  CUDA; wait() waits. */
class Execution {
 public:
  Stream stream{};

  auto policy() {
#if FUSE_FLOW_CUDA
    return thrust::cuda::par_nosync(scratch_).on(stream);
#else
    return thrust::device(scratch_);
#endif
  }

#if FUSE_FLOW_CUDA
  /** \brief Until note(nullptr), launch nothing but write down what would be: see LaunchGraph. */
  void note(std::vector<char>* where) {
    note_ = where;
    if (note_) note_->clear();
  }

  /** \brief A kernel of our own; nothing where there are no blocks. */
  template <typename... Parameters, typename... Arguments>
  void launch(const char* name, void (*kernel)(Parameters...), dim3 blocks, unsigned int threads,
              const Arguments&... arguments) {
    if (blocks.x == 0 || noted(kernel, blocks, threads, static_cast<Parameters>(arguments)...)) return;
    kernel<<<blocks, threads, 0, stream>>>(arguments...);
    check(cudaGetLastError(), name);
  }
#endif

  /** \brief step(k) for k = 0 … n − 1, in any order. */
  template <typename Step>
  void forEach(std::size_t n, const Step& step) {
    if (n == 0 || noted(&Execution::forEach<Step>, n, step)) return;
    translated([&] { thrust::for_each_n(policy(), thrust::counting_iterator<std::uint32_t>(0), n, step); });
  }

  template <typename Value>
  void fill(Value* where, std::size_t n, int byte) {
#if FUSE_FLOW_CUDA
    if (noted(&Execution::fill<Value>, where, n, byte)) return;
    check(cudaMemsetAsync(where, byte, n * sizeof(Value), stream), "cudaMemsetAsync");
#else
    std::memset(static_cast<void*>(where), byte, n * sizeof(Value));
#endif
  }

  /** \brief Between pinned memory and the device, either way, or within the device. */
  template <typename Value>
  void copy(Value* to, const Value* from, std::size_t n) {
#if FUSE_FLOW_CUDA
    if (n == 0 || noted(&Execution::copy<Value>, to, from, n)) return;
    check(cudaMemcpyAsync(to, from, n * sizeof(Value), cudaMemcpyDefault, stream), "cudaMemcpyAsync");
#else
    if (n > 0) std::memcpy(static_cast<void*>(to), static_cast<const void*>(from), n * sizeof(Value));
#endif
  }

  /** \brief As copy(), for a few words, by a kernel: in the copy engine they would queue behind the images and points of other
   *  frames in flight. */
  template <typename Value>
  void copySmall(Value* to, const Value* from, std::size_t n) {
    static_assert(sizeof(Value) % 4 == 0, "in words");
    forEach(n * sizeof(Value) / 4,
            CopyWords{reinterpret_cast<std::uint32_t*>(to), reinterpret_cast<const std::uint32_t*>(from)});
  }

  void wait() {
#if FUSE_FLOW_CUDA
    check(cudaStreamSynchronize(stream), "the frame's computation");
#endif
  }

  /** \brief Waits after an error, and is silent about others: then nothing reads or writes the memory any more that it was given. */
  void settle() noexcept {
#if FUSE_FLOW_CUDA
    (void)cudaStreamSynchronize(stream);
    (void)cudaGetLastError();
#endif
  }

  /** \brief sums[k] = Σ values[0 … k), k = 0 … n; n + 1 sums. */
  template <typename Input, typename Sum>
  void sumUp(Input values, std::size_t n, Sum* sums) {
    fill(sums, 1, 0);
    if (n > 0)
      translated([&] { thrust::inclusive_scan(policy(), values, values + static_cast<std::ptrdiff_t>(n), sums + 1); });
  }

  /** \brief Stable, by the lowest bits of the keys. The result may be in either of a pair of buffers: swaps them so that it is
   *  in the first. */
  template <typename Key>
  void sortByKey(DeviceBuffer<Key>& keys, DeviceBuffer<Key>& other_keys, DeviceBuffer<std::uint32_t>& values,
                 DeviceBuffer<std::uint32_t>& other_values, std::size_t n, int bits) {
    if (n < 2 || bits == 0) return;
#if FUSE_FLOW_CUDA
    cub::DoubleBuffer<Key> k(keys.data(), other_keys.data());
    cub::DoubleBuffer<std::uint32_t> v(values.data(), other_values.data());
    withScratch([&](void* scratch, std::size_t& bytes) {
      return cub::DeviceRadixSort::SortPairs(scratch, bytes, k, v, static_cast<int>(n), 0, bits, stream);
    });
    if (k.Current() != keys.data()) std::swap(keys, other_keys);
    if (v.Current() != values.data()) std::swap(values, other_values);
#else
    (void)other_keys;
    (void)other_values;
    thrust::stable_sort_by_key(policy(), keys.data(), keys.data() + n, values.data());
#endif
  }

  /** \brief The numbers 0 … n − 1 that the predicate chooses, ascending; how many goes to count, on the device. */
  template <typename Predicate>
  void select(std::size_t n, const Predicate& chosen, std::uint32_t* numbers, std::uint32_t* count) {
    fill(count, 1, 0);
    if (n == 0) return;
    const thrust::counting_iterator<std::uint32_t> all(0);
#if FUSE_FLOW_CUDA
    withScratch([&](void* scratch, std::size_t& bytes) {
      return cub::DeviceSelect::If(scratch, bytes, all, numbers, count, static_cast<int>(n), chosen, stream);
    });
#else
    *count = static_cast<std::uint32_t>(
        thrust::copy_if(policy(), all, all + static_cast<std::ptrdiff_t>(n), numbers, chosen) - numbers);
#endif
  }

  std::size_t scratchBytes() const { return scratch_.bytes(); }

 private:
  /** \brief Writes down the bytes of some values, if that is what is asked for. */
  template <typename... Values>
  bool noted(const Values&... values) {
#if FUSE_FLOW_CUDA
    if (note_ == nullptr) return false;
    (appendBytes(values, *note_), ...);
    return true;
#else
    ((void)values, ...);
    return false;
#endif
  }

  /** \brief Thrust's errors, of a kernel that finds no memory to be loaded into for one, as PCL's. */
  template <typename Action>
  static void translated(const Action& action) {
    try {
      action();
    } catch (const thrust::system_error& error) {
#if FUSE_FLOW_CUDA
      (void)cudaGetLastError();
#endif
      throw DeviceError(std::string("fuse_flow::gpu: ") + error.what());
    }
  }

#if FUSE_FLOW_CUDA
  std::vector<char>* note_{nullptr};

  template <typename Algorithm>
  void withScratch(const Algorithm& algorithm) {
    std::size_t bytes = 0;
    check(algorithm(nullptr, bytes), "CUB");
    char* scratch = scratch_.allocate(static_cast<std::ptrdiff_t>(bytes));
    const cudaError_t error = algorithm(scratch, bytes);
    scratch_.deallocate(scratch, bytes);
    check(error, "CUB");
  }
#endif

  ScratchAllocator scratch_;
};

}  // namespace gpu
}  // namespace fuse_flow
