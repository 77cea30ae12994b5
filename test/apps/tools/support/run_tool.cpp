#include "run_tool.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

namespace tool_test {
namespace {

[[noreturn]] void fail(const std::string& what) { throw std::runtime_error(what + ": " + std::strerror(errno)); }

/** \brief What the tool writes to, and where this process reads it. */
struct Channel {
  int read_end{-1};
  int write_end{-1};
};

Channel makePipe() {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) fail("pipe");
  return {ends[0], ends[1]};
}

/** \brief Without ends where there is none to be had. */
Channel openTerminal() {
  Channel channel;
  channel.read_end = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  if (channel.read_end < 0 || grantpt(channel.read_end) != 0 || unlockpt(channel.read_end) != 0) return channel;
  channel.write_end = open(ptsname(channel.read_end), O_RDWR | O_NOCTTY | O_CLOEXEC);
  return channel;
}

Channel makeTerminal() {
  const Channel channel = openTerminal();
  if (channel.write_end < 0) fail("terminal");
  return channel;
}

/** \brief What the started process, before it is the tool, does to itself. Nothing but system calls. */
void becomeTool(int out, int err, const std::optional<rlim_t>& file_size_limit) {
  dup2(out, STDOUT_FILENO);
  dup2(err, STDERR_FILENO);
  if (file_size_limit) {
    const rlimit limit{*file_size_limit, *file_size_limit};
    setrlimit(RLIMIT_FSIZE, &limit);
    const rlimit no_core{0, 0};
    setrlimit(RLIMIT_CORE, &no_core);
  }
  // If the tests were started in the background, or with nohup, these signals are ignored.
  for (const int number : {SIGINT, SIGQUIT, SIGHUP}) signal(number, SIG_DFL);
}

pid_t execute(const std::vector<std::string>& arguments, int out, int err, const RunOptions& options) {
  std::vector<char*> argv;
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  std::vector<char*> envp;
  for (const std::string& variable : options.environment) envp.push_back(const_cast<char*>(variable.c_str()));
  for (char** variable = environ; *variable != nullptr; ++variable) envp.push_back(*variable);
  envp.push_back(nullptr);
  const pid_t pid = fork();
  if (pid < 0) fail("fork");
  if (pid > 0) return pid;
  becomeTool(out, err, options.file_size_limit);
  execve(argv[0], argv.data(), envp.data());
  _exit(127);
}

int waitForStatus(pid_t pid) {
  int status = 0;
  while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

/** \brief Reads what there is; false once the other side has closed. */
bool drain(int descriptor, std::string& text) {
  std::array<char, 4096> bytes{};
  const ssize_t count = read(descriptor, bytes.data(), bytes.size());
  if (count > 0) text.append(bytes.data(), static_cast<std::size_t>(count));
  return count > 0 || (count < 0 && errno == EINTR);  // a terminal without a writer reports EIO
}

}  // namespace

bool terminalsAtHand() {
  const Channel channel = openTerminal();
  for (const int end : {channel.read_end, channel.write_end})
    if (end >= 0) close(end);
  return channel.write_end >= 0;
}

ToolResult runProgram(const std::string& path, const std::vector<std::string>& arguments, const RunOptions& options) {
  if (access(path.c_str(), X_OK) != 0) fail(path);
  std::vector<std::string> all{path};
  all.insert(all.end(), arguments.begin(), arguments.end());

  Channel out = makePipe();
  const Channel err = options.terminal ? makeTerminal() : makePipe();
  const int out_file =
      options.out_path.empty() ? out.write_end : open(options.out_path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
  if (out_file < 0) fail(options.out_path);
  const pid_t pid = execute(all, out_file, err.write_end, options);
  close(out.write_end);
  close(err.write_end);
  if (out_file != out.write_end) close(out_file);
  if (options.meanwhile) options.meanwhile(pid);

  ToolResult result;
  const auto deadline = std::chrono::steady_clock::now() + options.limit;
  std::array<pollfd, 2> polled{pollfd{out.read_end, POLLIN, 0}, pollfd{err.read_end, POLLIN, 0}};
  while (polled[0].fd >= 0 || polled[1].fd >= 0) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
    if (left.count() <= 0) {
      result.timed_out = true;
      kill(pid, SIGKILL);
      break;
    }
    poll(polled.data(), polled.size(), static_cast<int>(left.count()));
    if (polled[0].revents && !drain(polled[0].fd, result.out)) polled[0].fd = -1;
    if (polled[1].revents && !drain(polled[1].fd, result.err)) polled[1].fd = -1;
  }
  const int status = waitForStatus(pid);
  close(out.read_end);
  close(err.read_end);
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return result;
}

}  // namespace tool_test
