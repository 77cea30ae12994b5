#include "peak_memory.h"

#include "../sanitized.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstddef>

#ifdef FUSE_FLOW_TEST_SANITIZED
// Of the sanitizers' allocator_interface.h, which clang has, and gcc with the same library has not.
extern "C" {
int __sanitizer_install_malloc_and_free_hooks(void (*)(const volatile void*, std::size_t),
                                              void (*)(const volatile void*));
std::size_t __sanitizer_get_allocated_size(const volatile void*);
}
#elif defined(__GLIBC__)
#include <malloc.h>
#endif

namespace fuse_flow_fuzz {
namespace {

std::atomic<bool> counting{false};
std::atomic<long> now{0}, most{0};

void taken(std::size_t bytes) {
  if (!counting.load(std::memory_order_relaxed)) return;
  const long total = now.fetch_add(static_cast<long>(bytes), std::memory_order_relaxed) + static_cast<long>(bytes);
  long before = most.load(std::memory_order_relaxed);
  while (before < total && !most.compare_exchange_weak(before, total, std::memory_order_relaxed)) {
  }
}

/** \brief What was taken before is counted, too: the figure is then below 0 for a while, and the peak too small by that. */
void given(std::size_t bytes) {
  if (counting.load(std::memory_order_relaxed)) now.fetch_sub(static_cast<long>(bytes), std::memory_order_relaxed);
}

}  // namespace

PeakMemory::PeakMemory() {
#ifdef FUSE_FLOW_TEST_SANITIZED
  static const int hooks = __sanitizer_install_malloc_and_free_hooks(
      [](const volatile void*, std::size_t size) { taken(size); },
      [](const volatile void* memory) { given(__sanitizer_get_allocated_size(memory)); });
  static_cast<void>(hooks);
#endif
  now = 0;
  most = 0;
  counting = true;
}

PeakMemory::~PeakMemory() { counting = false; }

std::size_t PeakMemory::peak() const { return static_cast<std::size_t>(std::max(0L, most.load())); }

}  // namespace fuse_flow_fuzz

#if !defined(FUSE_FLOW_TEST_SANITIZED) && defined(__GLIBC__)
// The memory comes from glibc as before. Here and not in operator new, which ends here, as do Eigen's aligned allocations and those of C libraries.
extern "C" {
void* __libc_malloc(std::size_t) noexcept;
void* __libc_calloc(std::size_t, std::size_t) noexcept;
void* __libc_realloc(void*, std::size_t) noexcept;
void* __libc_memalign(std::size_t, std::size_t) noexcept;
void __libc_free(void*) noexcept;

static void* counted(void* memory) {
  if (memory) fuse_flow_fuzz::taken(malloc_usable_size(memory));
  return memory;
}

void* malloc(std::size_t size) noexcept { return counted(__libc_malloc(size)); }
void* calloc(std::size_t n, std::size_t size) noexcept { return counted(__libc_calloc(n, size)); }
void* realloc(void* memory, std::size_t size) noexcept {
  const std::size_t before = memory ? malloc_usable_size(memory) : 0;
  void* const result = __libc_realloc(memory, size);
  if (result || size == 0) fuse_flow_fuzz::given(before);
  return counted(result);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  return counted(__libc_memalign(alignment, size));
}
void* memalign(std::size_t alignment, std::size_t size) noexcept { return counted(__libc_memalign(alignment, size)); }
int posix_memalign(void** memory, std::size_t alignment, std::size_t size) noexcept {
  *memory = counted(__libc_memalign(alignment, size));
  return *memory || size == 0 ? 0 : ENOMEM;
}
void free(void* memory) noexcept {
  if (memory) fuse_flow_fuzz::given(malloc_usable_size(memory));
  __libc_free(memory);
}
}
#endif
