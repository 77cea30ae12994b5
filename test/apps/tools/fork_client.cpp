#include "fork_server.h"

#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <map>
#include <memory>
#include <stdexcept>

namespace tool_test {

ForkServer* ForkServer::of(const std::string& path) {
#ifdef FUSE_FLOW_TEST_TOOLS_FORK
  static const std::vector<std::string> forking{FUSE_FLOW_FUSE_TOOL,     FUSE_FLOW_CALIBRATE_TOOL,
                                                FUSE_FLOW_EVALUATE_TOOL, FUSE_FLOW_PICTURE_TOOL,
                                                FUSE_FLOW_SIMULATE_TOOL, FUSE_FLOW_EXPORT_TOOL};
  static std::map<std::string, std::unique_ptr<ForkServer>> started;
  if (std::find(forking.begin(), forking.end(), path) == forking.end()) return nullptr;
  std::unique_ptr<ForkServer>& server = started[path];
  if (!server) server.reset(new ForkServer(path));
  return server.get();
#else
  (void)path;
  return nullptr;
#endif
}

ForkServer::ForkServer(const std::string& path) : path_(path) {
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0) throw std::runtime_error("socketpair");
  const int far_end = dup(ends[1]);  // stays open in what is executed
  close(ends[1]);
  socket_ = ends[0];
  setenv(kForkServerVariable, std::to_string(far_end).c_str(), 1);
  server_ = fork();
  if (server_ == 0) {
    execl(path_.c_str(), path_.c_str(), nullptr);
    _exit(127);
  }
  unsetenv(kForkServerVariable);
  close(far_end);
  if (server_ < 0) throw std::runtime_error("fork");
}

ForkServer::~ForkServer() {
  close(socket_);
  waitpid(server_, nullptr, 0);
}

pid_t ForkServer::start(const std::vector<std::string>& arguments, int out, int err,
                        const std::optional<rlim_t>& file_size_limit) {
  const auto request = std::make_unique<ForkRequest>();
  request->limits_file_size = file_size_limit.has_value();
  request->file_size_limit = file_size_limit.value_or(0);
  for (const std::string& argument : arguments) {
    if (request->length + argument.size() + 1 > sizeof(request->arguments))
      throw std::runtime_error("too many arguments");
    std::memcpy(request->arguments + request->length, argument.c_str(), argument.size() + 1);
    request->length += argument.size() + 1;
  }

  iovec data{request.get(), sizeof(ForkRequest)};
  const int streams[]{out, err};
  alignas(cmsghdr) char beside[CMSG_SPACE(sizeof(streams))]{};
  msghdr message{};
  message.msg_iov = &data;
  message.msg_iovlen = 1;
  message.msg_control = beside;
  message.msg_controllen = sizeof(beside);
  cmsghdr* const descriptors = CMSG_FIRSTHDR(&message);
  descriptors->cmsg_level = SOL_SOCKET;
  descriptors->cmsg_type = SCM_RIGHTS;
  descriptors->cmsg_len = CMSG_LEN(sizeof(streams));
  std::memcpy(CMSG_DATA(descriptors), streams, sizeof(streams));
  if (sendmsg(socket_, &message, MSG_NOSIGNAL) < 0)
    throw std::runtime_error(path_ + " does not fork: " + std::strerror(errno));

  pid_t pid = -1;
  receive(&pid, sizeof(pid));
  return pid;
}

int ForkServer::waitForStatus() {
  int status = 0;
  receive(&status, sizeof(status));
  return status;
}

void ForkServer::receive(void* answer, std::size_t size) const {
  ssize_t received = -1;
  do received = recv(socket_, answer, size, 0);
  while (received < 0 && errno == EINTR);
  if (received != static_cast<ssize_t>(size)) throw std::runtime_error(path_ + " does not answer");
}

}  // namespace tool_test
