// A library that a test puts before the C library (LD_PRELOAD): it makes calls of a program fail as disks, kernels and clocks do. What fails stands in
// FUSE_FLOW_FAULTS, a list with blanks between:
//
//   read:ERROR:N    of reads from files below FUSE_FLOW_FAULTS_IN the N-th, from 1, and all after it fail with this error, a number
//   write:ERROR:N   of writes, and fsync, likewise
//   open:ERROR:N    of files that are opened, likewise
//   memory:SIZE:N   of allocations of SIZE bytes or more, and of mappings, the N-th fails, and all after it
//   thread:0:N      of threads that are begun, likewise
//   short           reads and writes do at most half of what they are asked for
//   interrupt       every second read or write ends with EINTR
//   slow            every read and write takes 2 ms longer
//   clock           the time of day jumps by an hour, forwards and back, at every seventh look
//
// Once something has failed, there is a file FUSE_FLOW_FAULTS_FIRED. Only what a program or a library other than the C library calls is seen, so not
// what fopen() and its kind read and write.
#include <dlfcn.h>
#include <fcntl.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>

extern "C" {
// The allocator's own names of what is replaced below.
void* __libc_malloc(size_t);
void* __libc_calloc(size_t, size_t);
void* __libc_realloc(void*, size_t);
void* __libc_memalign(size_t, size_t);
}

namespace {

/** \brief One "name:value:N" of the list. */
struct Fault {
  bool on{false};
  long value{0}, from{1};
  std::atomic<long> calls{0};

  /** \brief Counts a call. \returns whether it fails */
  bool fires() { return on && ++calls >= from; }
};

struct Faults {
  Fault read, write, open, memory, thread;
  bool cut_short{false}, interrupt{false}, slow{false}, clock{false};
  const char* folder{nullptr};
  const char* fired{nullptr};
  std::atomic<bool> told{false};
};

Faults faults;  // constant until main() but for the counts: no allocation, no order of initialisation

bool parse(const char* text, const char* name, Fault& fault) {
  const size_t length = std::strlen(name);
  if (std::strncmp(text, name, length) != 0 || text[length] != ':') return false;
  char* end = nullptr;
  fault.value = std::strtol(text + length + 1, &end, 10);
  if (*end == ':') fault.from = std::strtol(end + 1, nullptr, 10);
  fault.on = true;
  return true;
}

__attribute__((constructor)) void readFaults() {
  faults.folder = std::getenv("FUSE_FLOW_FAULTS_IN");
  faults.fired = std::getenv("FUSE_FLOW_FAULTS_FIRED");
  for (const char* at = std::getenv("FUSE_FLOW_FAULTS"); at && *at;
       at += std::strcspn(at, " "), at += std::strspn(at, " ")) {
    if (parse(at, "read", faults.read) || parse(at, "write", faults.write) || parse(at, "open", faults.open) ||
        parse(at, "memory", faults.memory) || parse(at, "thread", faults.thread))
      continue;
    const auto is = [at](const char* name) { return std::strncmp(at, name, std::strlen(name)) == 0; };
    faults.cut_short |= is("short");
    faults.interrupt |= is("interrupt");
    faults.slow |= is("slow");
    faults.clock |= is("clock");
  }
}

template <typename Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

/** \brief Leaves word that something has failed. */
void tell() {
  if (!faults.fired || faults.told.exchange(true)) return;
  const long descriptor = syscall(SYS_openat, AT_FDCWD, faults.fired, O_CREAT | O_WRONLY | O_CLOEXEC, 0600);
  if (descriptor >= 0) syscall(SYS_close, descriptor);
}

bool concerned(const char* path) {
  return faults.folder && std::strncmp(path, faults.folder, std::strlen(faults.folder)) == 0;
}

bool concerned(int descriptor) {
  if (!faults.folder) return false;
  char link[64], path[4096];
  std::snprintf(link, sizeof(link), "/proc/self/fd/%d", descriptor);
  const ssize_t length = readlink(link, path, sizeof(path) - 1);
  if (length <= 0) return false;
  path[length] = '\0';
  return concerned(path);
}

/** \brief What comes before a read or write. \returns false, and sets errno, if it fails */
bool begin(int descriptor, Fault& fault) {
  static std::atomic<unsigned int> calls{0};
  if (!concerned(descriptor)) return true;
  if (faults.slow) {
    const timespec pause{0, 2000000};
    syscall(SYS_nanosleep, &pause, nullptr);
    tell();
  }
  if (faults.interrupt && ++calls % 2) {
    tell();
    errno = EINTR;
    return false;
  }
  if (!fault.fires()) return true;
  tell();
  errno = static_cast<int>(fault.value);
  return false;
}

size_t cut(int descriptor, size_t bytes) {
  if (!faults.cut_short || bytes < 2 || !concerned(descriptor)) return bytes;
  tell();
  return bytes / 2;
}

/** \brief The pieces of a readv or writev, cut short likewise: half of the first that is not empty. \returns how many pieces there are now */
int cutPieces(int descriptor, const iovec*& pieces, int count, iovec& half) {
  if (!faults.cut_short || !concerned(descriptor)) return count;
  int k = 0;
  while (k < count && pieces[k].iov_len == 0) ++k;
  if (k == count) return count;
  tell();
  half = pieces[k];
  half.iov_len = std::max<size_t>(half.iov_len / 2, 1);
  pieces = &half;
  return 1;
}

bool memoryFails(size_t bytes) {
  if (!faults.memory.on || bytes < static_cast<size_t>(faults.memory.value) || !faults.memory.fires()) return false;
  tell();
  errno = ENOMEM;
  return true;
}

bool openFails(const char* path) {
  if (!faults.open.on || !path || !concerned(path) || !faults.open.fires()) return false;
  tell();
  errno = static_cast<int>(faults.open.value);
  return true;
}

mode_t modeOf(int flags, va_list arguments) {
  return flags & (O_CREAT | O_TMPFILE) ? static_cast<mode_t>(va_arg(arguments, int)) : 0;
}

}  // namespace

extern "C" {

ssize_t read(int descriptor, void* bytes, size_t count) {
  if (!begin(descriptor, faults.read)) return -1;
  return syscall(SYS_read, descriptor, bytes, cut(descriptor, count));
}

ssize_t pread(int descriptor, void* bytes, size_t count, off_t offset) {
  if (!begin(descriptor, faults.read)) return -1;
  return syscall(SYS_pread64, descriptor, bytes, cut(descriptor, count), offset);
}
ssize_t pread64(int descriptor, void* bytes, size_t count, off64_t offset) {
  return pread(descriptor, bytes, count, offset);
}

ssize_t readv(int descriptor, const iovec* pieces, int count) {
  if (!begin(descriptor, faults.read)) return -1;
  iovec half{};
  const int left = cutPieces(descriptor, pieces, count, half);
  return syscall(SYS_readv, descriptor, pieces, left);
}

ssize_t write(int descriptor, const void* bytes, size_t count) {
  if (!begin(descriptor, faults.write)) return -1;
  return syscall(SYS_write, descriptor, bytes, cut(descriptor, count));
}

ssize_t pwrite(int descriptor, const void* bytes, size_t count, off_t offset) {
  if (!begin(descriptor, faults.write)) return -1;
  return syscall(SYS_pwrite64, descriptor, bytes, cut(descriptor, count), offset);
}
ssize_t pwrite64(int descriptor, const void* bytes, size_t count, off64_t offset) {
  return pwrite(descriptor, bytes, count, offset);
}

ssize_t writev(int descriptor, const iovec* pieces, int count) {
  if (!begin(descriptor, faults.write)) return -1;
  iovec half{};
  const int left = cutPieces(descriptor, pieces, count, half);
  return syscall(SYS_writev, descriptor, pieces, left);
}

int fsync(int descriptor) {
  if (!begin(descriptor, faults.write)) return -1;
  return static_cast<int>(syscall(SYS_fsync, descriptor));
}

int open(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = modeOf(flags, arguments);
  va_end(arguments);
  return openFails(path) ? -1 : static_cast<int>(syscall(SYS_openat, AT_FDCWD, path, flags, mode));
}
int open64(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = modeOf(flags, arguments);
  va_end(arguments);
  return openFails(path) ? -1 : static_cast<int>(syscall(SYS_openat, AT_FDCWD, path, flags, mode));
}
FILE* fopen(const char* path, const char* mode) {
  static const auto real = next<FILE* (*)(const char*, const char*)>("fopen");
  return openFails(path) ? nullptr : real(path, mode);
}
FILE* fopen64(const char* path, const char* mode) {
  static const auto real = next<FILE* (*)(const char*, const char*)>("fopen64");
  return openFails(path) ? nullptr : real(path, mode);
}

void* mmap(void* address, size_t bytes, int protection, int flags, int descriptor, off_t offset) {
  if (memoryFails(bytes)) return MAP_FAILED;
  return reinterpret_cast<void*>(syscall(SYS_mmap, address, bytes, protection, flags, descriptor, offset));
}
void* mmap64(void* address, size_t bytes, int protection, int flags, int descriptor, off64_t offset) {
  return mmap(address, bytes, protection, flags, descriptor, offset);
}

void* malloc(size_t bytes) { return memoryFails(bytes) ? nullptr : __libc_malloc(bytes); }
void* calloc(size_t count, size_t bytes) {
  size_t all = 0;
  if (__builtin_mul_overflow(count, bytes, &all) || memoryFails(all)) return nullptr;
  return __libc_calloc(count, bytes);
}
void* realloc(void* old, size_t bytes) { return memoryFails(bytes) ? nullptr : __libc_realloc(old, bytes); }
void* memalign(size_t alignment, size_t bytes) {
  return memoryFails(bytes) ? nullptr : __libc_memalign(alignment, bytes);
}
void* aligned_alloc(size_t alignment, size_t bytes) { return memalign(alignment, bytes); }
int posix_memalign(void** result, size_t alignment, size_t bytes) {
  void* memory = memalign(alignment, bytes);
  if (!memory) return ENOMEM;
  *result = memory;
  return 0;
}

int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*start)(void*), void* argument) {
  static const auto real = next<int (*)(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*)>("pthread_create");
  if (faults.thread.fires()) {
    tell();
    return EAGAIN;
  }
  return real(thread, attributes, start, argument);
}

int clock_gettime(clockid_t clock, timespec* time) {
  static std::atomic<unsigned int> looks{0};
  static const auto real = next<int (*)(clockid_t, timespec*)>("clock_gettime");
  const int result = real(clock, time);
  if (faults.clock && clock == CLOCK_REALTIME) {
    const unsigned int jump = ++looks / 7;
    if (jump > 0) tell();
    time->tv_sec += jump % 2 ? 3600 : -3600;
  }
  return result;
}

}  // extern "C"
