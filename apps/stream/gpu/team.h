#pragma once

#include <fuse_flow/math/host_device.h>

#include <cstdint>

/** \file
 *  \brief Work that several threads do together, written once: a team is a block of threads on a GPU, and one thread on the CPU. What a
 *  function of a team has written, all of its threads see in the next. */

namespace fuse_flow::stream {

/** \brief Threads of a block. */
constexpr std::uint32_t kTeamThreads = 256;

/** \brief A team of one. */
struct Alone {
  /** \brief step(0) … step(n − 1), in any order. */
  FUSE_FLOW_CALLS_ANY
  template <typename Step>
  FUSE_FLOW_HD void forEach(std::uint32_t n, const Step& step) const {
    for (std::uint32_t k = 0; k < n; ++k) step(k);
  }
  /** \brief Something that one of them does. */
  FUSE_FLOW_CALLS_ANY
  template <typename Step>
  FUSE_FLOW_HD void once(const Step& step) const {
    step();
  }
  ///@{
  /** \brief Inside of a step, of words that several steps write. */
  FUSE_FLOW_HD void add(std::uint32_t* where, std::uint32_t value) const { *where += value; }
  FUSE_FLOW_HD void raise(std::uint32_t* where, std::uint32_t value) const {
    if (*where < value) *where = value;
  }
  FUSE_FLOW_HD void setBits(std::uint32_t* where, std::uint32_t bits) const { *where |= bits; }
  ///@}
  /** \brief values[k] becomes the sum of those before it. \param n at most kTeamThreads \returns the sum of all */
  FUSE_FLOW_HD std::uint32_t sumUp(std::uint32_t* values, std::uint32_t n) const {
    std::uint32_t sum = 0;
    for (std::uint32_t k = 0; k < n; ++k) {
      const std::uint32_t value = values[k];
      values[k] = sum;
      sum += value;
    }
    return sum;
  }
};

#if defined(__CUDACC__)

/** \brief A block of kTeamThreads threads. All of them call its functions. */
struct ThreadBlock {
  static constexpr std::uint32_t kWarps = kTeamThreads / 32;
  std::uint32_t* sums;  ///< shared memory, kWarps words

  template <typename Step>
  __device__ void forEach(std::uint32_t n, const Step& step) const {
    for (std::uint32_t k = threadIdx.x; k < n; k += kTeamThreads) step(k);
    __syncthreads();
  }
  template <typename Step>
  __device__ void once(const Step& step) const {
    if (threadIdx.x == 0) step();
    __syncthreads();
  }
  __device__ void add(std::uint32_t* where, std::uint32_t value) const { atomicAdd(where, value); }
  __device__ void raise(std::uint32_t* where, std::uint32_t value) const { atomicMax(where, value); }
  __device__ void setBits(std::uint32_t* where, std::uint32_t bits) const { atomicOr(where, bits); }
  __device__ std::uint32_t sumUp(std::uint32_t* values, std::uint32_t n) const {
    const std::uint32_t lane = threadIdx.x % 32, warp = threadIdx.x / 32;
    const std::uint32_t value = threadIdx.x < n ? values[threadIdx.x] : 0;
    std::uint32_t sum = value;
    for (std::uint32_t distance = 1; distance < 32; distance *= 2) {
      const std::uint32_t before = __shfl_up_sync(0xffffffffu, sum, distance);
      if (lane >= distance) sum += before;
    }
    if (lane == 31) sums[warp] = sum;
    __syncthreads();
    std::uint32_t before = 0, all = 0;
    for (std::uint32_t k = 0; k < kWarps; ++k) {
      if (k == warp) before = all;
      all += sums[k];
    }
    if (threadIdx.x < n) values[threadIdx.x] = before + sum - value;
    __syncthreads();
    return all;
  }
};

#endif

}  // namespace fuse_flow::stream
