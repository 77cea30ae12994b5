#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

namespace fuse_flow::test {

/** \brief A TCP connection as it is, for what no well-behaved client or server does. Everything waits for a generous time, and throws then. */
class RawSocket {
 public:
  explicit RawSocket(int fd) : fd_(fd) {}
  RawSocket(RawSocket&& other) noexcept : fd_(std::exchange(other.fd_, -1)), rest_(std::move(other.rest_)) {}
  RawSocket& operator=(RawSocket&&) = delete;
  ~RawSocket() { close(); }

  static RawSocket to(std::uint16_t port) {
    RawSocket result(::socket(AF_INET, SOCK_STREAM, 0));
    if (!result.connect(port)) throw std::runtime_error("connect");
    return result;
  }
  bool connect(std::uint16_t port) {
    const sockaddr_in address = loopback(port);
    return ::connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
  }
  static sockaddr_in loopback(std::uint16_t port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(port);
    return address;
  }

  void close() {
    if (fd_ >= 0) ::close(std::exchange(fd_, -1));
  }
  /** \brief With a reset, as a machine does that has forgotten the connection. */
  void reset() {
    const linger now{1, 0};
    ::setsockopt(fd_, SOL_SOCKET, SO_LINGER, &now, sizeof(now));
    close();
  }
  void receiveBuffer(int bytes) { ::setsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &bytes, sizeof(bytes)); }

  /** \brief False: the other side has gone. */
  bool send(const std::string& bytes) {
    std::size_t done = 0;
    while (done < bytes.size()) {
      const ssize_t sent = ::send(fd_, bytes.data() + done, bytes.size() - done, MSG_NOSIGNAL);
      if (sent <= 0) return false;
      done += static_cast<std::size_t>(sent);
    }
    return true;
  }
  /** \brief What comes; empty: the other side has ended. */
  std::string some(std::chrono::milliseconds timeout = std::chrono::seconds(30)) {
    if (!rest_.empty()) return std::exchange(rest_, {});
    pollfd poll{fd_, POLLIN, 0};
    if (::poll(&poll, 1, static_cast<int>(timeout.count())) <= 0) throw std::runtime_error("nothing came");
    std::string bytes(1 << 16, '\0');
    const ssize_t count = ::recv(fd_, bytes.data(), bytes.size(), 0);
    bytes.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
    return bytes;
  }
  std::string exactly(std::size_t size) {
    std::string bytes;
    while (bytes.size() < size) {
      const std::string more = some();
      if (more.empty()) throw std::runtime_error("it has ended");
      bytes += more;
    }
    rest_ = bytes.substr(size);
    bytes.resize(size);
    return bytes;
  }
  std::string until(const std::string& end) {
    std::string bytes;
    while (bytes.find(end) == std::string::npos) {
      const std::string more = some();
      if (more.empty()) return bytes;
      bytes += more;
    }
    const std::size_t at = bytes.find(end) + end.size();
    rest_ = bytes.substr(at);
    bytes.resize(at);
    return bytes;
  }
  /** \brief All that comes before the other side ends. */
  std::string all() {
    std::string bytes;
    for (;;) {
      const std::string more = some();
      if (more.empty()) return bytes;
      bytes += more;
    }
  }

 private:
  int fd_;
  std::string rest_;
};

/** \brief What a client asks for to get a stream. */
inline std::string streamRequest(std::uint16_t port, const std::string& headers = "",
                                 const std::string& target = "/stream",
                                 const std::string& subprotocol = "fuse_flow.v1") {
  return "GET " + target + " HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port) +
         "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
         "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Protocol: " +
         subprotocol + "\r\n" + headers + "\r\n";
}

/** \brief The number in the first line of an answer; 0: there is none. */
inline int statusOf(const std::string& answer) {
  return answer.rfind("HTTP/1.1 ", 0) == 0 ? std::stoi(answer.substr(9, 3)) : 0;
}

enum Opcode { kContinuation = 0, kText = 1, kBinary = 2, kClose = 8, kPing = 9, kPong = 10 };

/** \brief A frame of the WebSocket protocol. */
inline std::string webSocketFrame(int opcode, const std::string& payload, bool masked, bool final = true) {
  std::string frame;
  frame += static_cast<char>((final ? 0x80 : 0) | opcode);
  const char mask = masked ? static_cast<char>(0x80) : 0;
  if (payload.size() < 126) {
    frame += static_cast<char>(mask | static_cast<char>(payload.size()));
  } else if (payload.size() < 65536) {
    frame += static_cast<char>(mask | 126);
    for (int shift = 8; shift >= 0; shift -= 8) frame += static_cast<char>(payload.size() >> shift);
  } else {
    frame += static_cast<char>(mask | 127);
    for (int shift = 56; shift >= 0; shift -= 8) frame += static_cast<char>(payload.size() >> shift);
  }
  if (masked) frame += std::string(4, '\0');  // which leaves the payload as it is
  return frame + payload;
}

/** \brief A WebSocket that does what a test says, and nothing by itself. */
class RawWebSocket {
 public:
  struct Frame {
    int opcode;
    std::string payload;
    /** \brief Of a close frame. */
    int code() const {
      return payload.size() < 2 ? 0
                                : static_cast<unsigned char>(payload[0]) * 256 + static_cast<unsigned char>(payload[1]);
    }
  };

  explicit RawWebSocket(std::uint16_t port, const std::string& headers = "", const std::string& target = "/stream",
                        const std::string& subprotocol = "fuse_flow.v1")
      : socket(RawSocket::to(port)) {
    socket.send(streamRequest(port, headers, target, subprotocol));
    answer = socket.until("\r\n\r\n");
    if (statusOf(answer) != 101) throw std::runtime_error(answer);
  }

  bool send(int opcode, const std::string& payload) { return socket.send(webSocketFrame(opcode, payload, true)); }
  Frame read() {
    const std::string start = socket.exactly(2);
    std::uint64_t size = static_cast<unsigned char>(start[1]) & 127u;
    if (size > 125) {
      const std::string bytes = socket.exactly(size == 126 ? 2 : 8);
      size = 0;
      for (const char c : bytes) size = size << 8 | static_cast<unsigned char>(c);
    }
    return {start[0] & 15, socket.exactly(size)};
  }
  /** \brief The next of a kind. Pings are answered. */
  Frame next(int opcode) {
    for (;;) {
      Frame frame = read();
      if (frame.opcode == kPing) send(kPong, frame.payload);
      if (frame.opcode == opcode) return frame;
      if (frame.opcode == kClose) throw std::runtime_error("closed with " + std::to_string(frame.code()));
    }
  }
  /** \brief The next frame of points; answered. */
  std::string nextFrame() {
    std::string message = next(kBinary).payload;
    std::uint64_t number;
    std::memcpy(&number, message.data() + 8, sizeof(number));
    send(kText, R"({"type":"got","frame":)" + std::to_string(number) + "}");
    return message;
  }
  /** \brief The code that the server closes with; frames before it are not answered. 0: without a word. */
  int closeCode() {
    try {
      for (;;) {
        const Frame frame = read();
        if (frame.opcode == kPing) send(kPong, frame.payload);
        if (frame.opcode == kClose) return frame.code();
      }
    } catch (const std::exception& error) {
      if (error.what() != std::string("it has ended")) throw;
      return 0;
    }
  }

  RawSocket socket;
  std::string answer;
};

/** \brief Listens at a port that is free; a test plays the server. */
class RawListener {
 public:
  RawListener() : fd_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address = RawSocket::loopback(0);
    ::bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof(address));
    ::listen(fd_, 16);
    socklen_t size = sizeof(address);
    ::getsockname(fd_, reinterpret_cast<sockaddr*>(&address), &size);
    port_ = ntohs(address.sin_port);
  }
  ~RawListener() { ::close(fd_); }
  RawListener(const RawListener&) = delete;
  RawListener& operator=(const RawListener&) = delete;

  std::uint16_t port() const { return port_; }
  std::string link() const { return "ws://127.0.0.1:" + std::to_string(port_); }
  RawSocket accept() {
    pollfd poll{fd_, POLLIN, 0};
    if (::poll(&poll, 1, 30'000) <= 0) throw std::runtime_error("nobody came");
    return RawSocket(::accept(fd_, nullptr, nullptr));
  }

 private:
  int fd_;
  std::uint16_t port_{0};
};

/** \brief Waits until it holds, for a generous time. */
template <typename Condition>
bool eventually(const Condition& holds, std::chrono::seconds most = std::chrono::seconds(30)) {
  const auto end = std::chrono::steady_clock::now() + most;
  while (!holds()) {
    if (std::chrono::steady_clock::now() > end) return false;
    ::usleep(2000);
  }
  return true;
}

}  // namespace fuse_flow::test
