#pragma once

/** \file
 *  \brief What a process has at the moment, for benchmarks that look for leaks. Linux. */

#include <unistd.h>

#include <cstddef>
#include <filesystem>
#include <fstream>

namespace bench {

/** \brief What must not grow while a program runs for hours. */
struct ProcessState {
  double megabytes{0};         ///< resident memory
  std::size_t descriptors{0};  ///< open files and sockets
  std::size_t threads{0};
};

inline std::size_t entriesOf(const char* folder) {
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) count += entry.path().empty() ? 0 : 1;
  return count;
}

inline ProcessState processState() {
  std::ifstream file("/proc/self/statm");
  long all = 0, resident = 0;
  file >> all >> resident;
  return {1e-6 * static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE)), entriesOf("/proc/self/fd"),
          entriesOf("/proc/self/task")};
}

}  // namespace bench
