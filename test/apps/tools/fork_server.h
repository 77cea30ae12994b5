#pragma once

#include <sys/resource.h>
#include <sys/types.h>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

// Under the address sanitizer it takes longer to start a tool than to run it, and the tests start hundreds. There each tool is
// started once, stops before its main() (fork_server.cpp, which is linked into it), and forks for every run that is asked for.

namespace tool_test {

/** \brief What a started process, before it is the tool, does to itself. Nothing but system calls. */
void becomeTool(int out, int err, const std::optional<rlim_t>& file_size_limit);

/** \brief The environment variable that names the descriptor that requests come from; without it a tool just runs. */
constexpr char kForkServerVariable[] = "FUSE_FLOW_TEST_FORK_SERVER";

/** \brief A packet that comes with two descriptors: the standard output and the standard error stream. The answers are the pid_t of
 *  the process, and once it has ended an int, as waitpid() gives it. */
struct ForkRequest {
  bool limits_file_size{false};
  rlim_t file_size_limit{0};
  std::size_t length{0};
  /** \brief The arguments, from the path on, with a zero after each. */
  char arguments[1 << 16];
};

/** \brief A tool that has started and waits. */
class ForkServer {
 public:
  /** \brief The one of this program, started when it is first asked for; nullptr for a program that has none. */
  static ForkServer* of(const std::string& path);

  ForkServer(const ForkServer&) = delete;
  ForkServer& operator=(const ForkServer&) = delete;
  ~ForkServer();

  /** \brief Throws std::runtime_error if the tool is gone. */
  pid_t start(const std::vector<std::string>& arguments, int out, int err,
              const std::optional<rlim_t>& file_size_limit);
  /** \brief Of what was started last. */
  int waitForStatus();

 private:
  explicit ForkServer(const std::string& path);
  void receive(void* answer, std::size_t size) const;

  std::string path_;
  pid_t server_{-1};
  int socket_{-1};
};

}  // namespace tool_test
