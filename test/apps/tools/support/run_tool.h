#pragma once

#include <sys/resource.h>
#include <sys/types.h>

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace tool_test {

/** \brief How a tool is run. */
struct RunOptions {
  /** \brief The standard error stream is a terminal. */
  bool terminal{false};
  /** \brief Where the standard output stream goes; empty: into ToolResult::out. */
  std::string out_path;
  /** \brief No file may grow larger than this, bytes, as with `ulimit -f`. */
  std::optional<rlim_t> file_size_limit;
  /** \brief "NAME=value", beside the environment of this process. */
  std::vector<std::string> environment;
  /** \brief Called once in this process, as soon as the tool runs. */
  std::function<void(pid_t)> meanwhile;
  /** \brief A tool that takes longer hangs: it is ended, and the result says so. No test expects less. */
  std::chrono::seconds limit{240};
};

struct ToolResult {
  /** \brief As a shell reports it: 128 + the signal's number for a tool that a signal ended. */
  int exit_code{-1};
  bool timed_out{false};
  std::string out;
  std::string err;
};

/** \brief Starts a program by its path, and waits for it. Throws std::runtime_error if it cannot be started. */
ToolResult runProgram(const std::string& path, const std::vector<std::string>& arguments,
                      const RunOptions& options = {});

inline ToolResult fuse(const std::vector<std::string>& arguments, const RunOptions& options = {}) {
  return runProgram(FUSE_FLOW_FUSE_TOOL, arguments, options);
}
inline ToolResult evaluate(const std::vector<std::string>& arguments, const RunOptions& options = {}) {
  return runProgram(FUSE_FLOW_EVALUATE_TOOL, arguments, options);
}

/** \brief Whether RunOptions::terminal can be had: not where /dev/pts is not mounted, as in some chroots. */
bool terminalsAtHand();

}  // namespace tool_test
