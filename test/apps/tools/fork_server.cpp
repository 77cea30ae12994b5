// Linked into a tool with --wrap=main: what is called for main().

#include "fork_server.h"

#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

extern "C" int __real_main(int argc, char** argv);
extern "C" int __wrap_main(int argc, char** argv);

namespace {

using namespace tool_test;

ForkRequest request;  // outlives every frame, as its arguments must

/** \brief False when nobody asks any more. */
bool receiveRequest(int socket, int (&streams)[2]) {
  iovec data{&request, sizeof(request)};
  alignas(cmsghdr) char beside[CMSG_SPACE(sizeof(streams))];
  msghdr message{};
  message.msg_iov = &data;
  message.msg_iovlen = 1;
  message.msg_control = beside;
  message.msg_controllen = sizeof(beside);
  ssize_t received = -1;
  do received = recvmsg(socket, &message, MSG_CMSG_CLOEXEC);
  while (received < 0 && errno == EINTR);
  if (received != sizeof(request)) return false;
  std::memcpy(streams, CMSG_DATA(CMSG_FIRSTHDR(&message)), sizeof(streams));
  return true;
}

int runAsRequested(const int (&streams)[2]) {
  becomeTool(streams[0], streams[1],
             request.limits_file_size ? std::make_optional(request.file_size_limit) : std::nullopt);
  for (const int stream : streams) close(stream);
  static std::vector<char*> argv;
  for (char* next = request.arguments; next < request.arguments + request.length; next += std::strlen(next) + 1)
    argv.push_back(next);
  argv.push_back(nullptr);
  return __real_main(static_cast<int>(argv.size()) - 1, argv.data());
}

}  // namespace

int __wrap_main(int argc, char** argv) {
  const char* descriptor = std::getenv(kForkServerVariable);
  if (!descriptor) return __real_main(argc, argv);
  const int socket = std::atoi(descriptor);
  unsetenv(kForkServerVariable);  // for what the tool starts
  int streams[2];
  while (receiveRequest(socket, streams)) {
    const pid_t pid = fork();
    if (pid == 0) {
      close(socket);
      return runAsRequested(streams);
    }
    for (const int stream : streams) close(stream);
    if (pid < 0 || send(socket, &pid, sizeof(pid), MSG_NOSIGNAL) != sizeof(pid)) break;
    int status = 0;
    while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
    }
    if (send(socket, &status, sizeof(status), MSG_NOSIGNAL) != sizeof(status)) break;
  }
  _exit(0);
}
