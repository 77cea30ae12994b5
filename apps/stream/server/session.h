#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace fuse_flow::stream::network {

/** \brief A message to a client: pieces of memory, in order, which are not copied. */
struct Outgoing {
  struct Piece {
    const void* data;
    std::size_t size;
  };
  bool binary{false};
  std::vector<Piece> pieces;
  std::shared_ptr<const void> held;  ///< what the pieces point into

  static Outgoing text(std::string text) {
    const auto held = std::make_shared<const std::string>(std::move(text));
    return {false, {{held->data(), held->size()}}, held};
  }
};

/** \brief Why a WebSocket is closed, RFC 6455. */
enum CloseCode : std::uint16_t { kGoingAway = 1001, kPolicy = 1008, kTooBig = 1009, kTryLater = 1013 };

/** \brief A WebSocket, as a session sees it. Sessions call it from within their own members only, but for those that say so. */
class Channel {
 public:
  virtual ~Channel() = default;
  /** \brief One at a time: the next after Session::sent(). */
  virtual void send(Outgoing message) = 0;
  /** \brief Session::pong() follows. While one is under way it does nothing. */
  virtual void ping() = 0;
  /** \brief Session::woken() follows then, or earlier. The latest call holds. */
  virtual void wakeAt(std::chrono::steady_clock::time_point time) = 0;
  /** \param reason at most 123 bytes of ASCII. What is being sent is ended first, if that takes no longer than a second. */
  virtual void close(CloseCode code, const std::string& reason) = 0;
  /** \brief With its port, for people. */
  virtual const std::string& address() const = 0;

  /** \brief Any thread: Session::woken() follows, once for many calls. */
  virtual void wake() = 0;
  /** \brief Any thread: ends without a word, and frees what is held. */
  virtual void drop() = 0;
  /** \brief Any thread: close() with kGoingAway. */
  virtual void goAway() = 0;
};

/** \brief What a subprotocol does with one client. Its members are called one after the other. */
class Session {
 public:
  virtual ~Session() = default;
  virtual void opened() = 0;
  virtual void received(std::string_view message, bool binary) = 0;
  /** \brief What was given to Channel::send() is out. */
  virtual void sent() = 0;
  virtual void pong(std::chrono::steady_clock::duration round_trip) = 0;
  virtual void woken() = 0;
  /** \brief Once, at the end; nothing is called after it. */
  virtual void closed() = 0;
};

/** \param channel owns the session, and outlives it */
using SessionFactory = std::function<std::unique_ptr<Session>(const std::shared_ptr<Channel>& channel)>;

/** \brief What a server speaks over WebSockets. */
struct Subprotocol {
  std::string name;
  std::string path;  ///< where; empty: anywhere
  SessionFactory begin;
  std::size_t most_message{4096};  ///< bytes of what a client says at once
};

}  // namespace fuse_flow::stream::network
