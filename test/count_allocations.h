#pragma once

/** \file
 *  \brief Counts what is taken from malloc. For one source of a program: it defines malloc itself rather than operator new, which ends
 *  there, as do Eigen's aligned allocations, which PCL's clouds use. */

#include "sanitized.h"

#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdlib>

#if defined(__GLIBC__)
#include <malloc.h>
#endif
#if __has_include(<mm_malloc.h>)
#include <mm_malloc.h>  // clang's declares posix_memalign() otherwise than below, which is no error only if it comes first
#endif

// CUDA's driver allocates as it likes.
#if defined(__GLIBC__) && !defined(FUSE_FLOW_TEST_SANITIZED) && !defined(__CUDACC__)
#define FUSE_FLOW_TEST_COUNTS_ALLOCATIONS 1
#endif

namespace count_allocations {

inline std::atomic<bool> counting{false};
inline std::atomic<long> allocations{0};
inline std::atomic<long> failing{-1};  ///< number of the one that is refused; −1: none

/** \brief How many an action makes, on all threads; 0 where they are not counted. */
template <typename Action>
long allocationsOf(const Action& action) {
  allocations = 0;
  counting = true;
  action();
  counting = false;
  return allocations;
}

/** \brief The same, with one allocation refused: the number-th, from 0 on. */
template <typename Action>
void refuseAllocation(long number, const Action& action) {
  failing = number;
  try {
    allocationsOf(action);
  } catch (...) {
    counting = false;
    failing = -1;
    throw;
  }
  failing = -1;
}

/** \brief Whether the allocation is refused. */
inline bool count() noexcept {
  return counting.load(std::memory_order_relaxed) &&
         allocations.fetch_add(1, std::memory_order_relaxed) == failing.load(std::memory_order_relaxed);
}

}  // namespace count_allocations

#if defined(FUSE_FLOW_TEST_COUNTS_ALLOCATIONS)
// The memory comes from glibc as before, so that its free() takes it back.
extern "C" {
void* __libc_malloc(std::size_t) noexcept;
void* __libc_calloc(std::size_t, std::size_t) noexcept;
void* __libc_realloc(void*, std::size_t) noexcept;
void* __libc_memalign(std::size_t, std::size_t) noexcept;

void* malloc(std::size_t size) noexcept { return count_allocations::count() ? nullptr : __libc_malloc(size); }
void* calloc(std::size_t n, std::size_t size) noexcept {
  return count_allocations::count() ? nullptr : __libc_calloc(n, size);
}
void* realloc(void* memory, std::size_t size) noexcept {
  return count_allocations::count() ? nullptr : __libc_realloc(memory, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  return count_allocations::count() ? nullptr : __libc_memalign(alignment, size);
}
int posix_memalign(void** memory, std::size_t alignment, std::size_t size) noexcept {
  if (count_allocations::count()) return ENOMEM;
  *memory = __libc_memalign(alignment, size);
  return *memory || size == 0 ? 0 : ENOMEM;
}
}
#endif
