// Preloaded into the compilers by .ci/compile: gcc asks for its memory 2 MB at a time, on pages of 4 KB, and on a virtual machine a
// fifth of its time goes into finding them. Here it gets it from pages of 2 MB, where the system has "madvise" in
// /sys/kernel/mm/transparent_hugepage/enabled; with "never" it changes nothing, and with "always" there is little to gain.

#define _GNU_SOURCE
#include <stddef.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

#define THREAD_LOCAL _Thread_local __attribute__((tls_model("initial-exec")))

enum { kPage = 4096, kPool = 256 << 20, kLargest = 64 << 20 };

static void* map(void* address, size_t size, int protection, int flags, int file, off_t offset) {
  return (void*)syscall(SYS_mmap, address, size, protection, flags, file, offset);
}

void* mmap(void* address, size_t size, int protection, int flags, int file, off_t offset) {
  static THREAD_LOCAL char* next;
  static THREAD_LOCAL size_t left;
  if (address || file != -1 || flags != (MAP_PRIVATE | MAP_ANONYMOUS) || protection != (PROT_READ | PROT_WRITE) ||
      size > kLargest)
    return map(address, size, protection, flags, file, offset);
  size = (size + kPage - 1) / kPage * kPage;
  if (left < size) {
    void* const pool = map(NULL, kPool, protection, flags | MAP_NORESERVE, -1, 0);
    if (pool == MAP_FAILED) return map(address, size, protection, flags, file, offset);
    madvise(pool, kPool, MADV_HUGEPAGE);
    next = pool;
    left = kPool;
  }
  char* const result = next;
  next += size;
  left -= size;
  return result;
}

void* mmap64(void* address, size_t size, int protection, int flags, int file, off_t offset) {
  return mmap(address, size, protection, flags, file, offset);
}
