#pragma once

#include "stream/server/gate.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

namespace fuse_flow::stream::network {

/** \brief The threads of a server, and its socket. */
class Listener {
 public:
  struct Options {
    std::string address;
    std::uint16_t port{0};
    std::string certificate, key;  ///< files; empty: without TLS
    int threads{1};
    std::size_t connections_per_second{50};
  };

  /** \brief Listens, but lets nobody in yet. \throws std::runtime_error */
  Listener(const Options& options, std::shared_ptr<Gate> gate);
  /** \brief Nobody comes in any more, and all that is under way ends at once. */
  ~Listener();
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  void start();
  /** \brief Nobody comes in any more. */
  void shut();
  std::uint16_t port() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/** \brief Whether it is a loopback address. \throws std::invalid_argument if it is no IP address */
bool isLoopbackAddress(const std::string& address);

/** \brief How others name an address in a link: an address of this machine for those that mean all of them; IPv6 in brackets. */
std::string hostInLinks(const std::string& address);

}  // namespace fuse_flow::stream::network
