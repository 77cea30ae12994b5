#pragma once

#include "stream/network/link.h"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace fuse_flow::stream::network {

/** \brief What a client hears of, in the connection's thread. What it throws ends the connection: the server has sent what it must not. */
struct ClientEvents {
  std::function<void()> opened;
  std::function<void(std::string&& text)> text;
  std::function<void(std::vector<std::uint8_t>&& bytes)> binary;
  /** \brief A connection was lost, or could not be made. \param error one line \param final no other attempt follows */
  std::function<void(const std::string& error, bool final)> lost;
};

/** \brief A WebSocket to a server, which comes back when it is lost. It has a thread of its own. */
class ClientConnection {
 public:
  struct Options {
    Link link;
    std::string token;
    std::string subprotocol;
    std::size_t most_bytes{0};
    std::string certificate_authority;
    bool verify{true};
    bool reconnect{true};
    std::chrono::milliseconds connect_time{0}, silence{0};
  };

  /** \throws std::runtime_error if the certificates cannot be used */
  ClientConnection(const Options& options, ClientEvents events);
  ~ClientConnection();
  ClientConnection(const ClientConnection&) = delete;
  ClientConnection& operator=(const ClientConnection&) = delete;

  void start();
  /** \brief Any thread: sends a text, if there is a connection. A text of the same kind that still waits is replaced by it, unless that is
   *  empty. */
  void send(std::string kind, std::string text);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace fuse_flow::stream::network
