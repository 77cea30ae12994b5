#include "fork_server.h"

#include <signal.h>
#include <unistd.h>

namespace tool_test {

void becomeTool(int out, int err, const std::optional<rlim_t>& file_size_limit) {
  dup2(out, STDOUT_FILENO);
  dup2(err, STDERR_FILENO);
  if (file_size_limit) {
    const rlimit limit{*file_size_limit, *file_size_limit};
    setrlimit(RLIMIT_FSIZE, &limit);
    const rlimit no_core{0, 0};
    setrlimit(RLIMIT_CORE, &no_core);
  }
  // Whoever started the tests in the background, or with nohup, has had them ignored.
  for (const int number : {SIGINT, SIGQUIT, SIGHUP}) signal(number, SIG_DFL);
}

}  // namespace tool_test
