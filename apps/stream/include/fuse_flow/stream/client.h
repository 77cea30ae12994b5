#pragma once

#include <fuse_flow/stream/description.h>
#include <fuse_flow/stream/encoded_frame.h>
#include <fuse_flow/stream/streamed_cloud.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace fuse_flow::stream {

struct ClientOptions {
  std::string token;  ///< what the server asks for; empty: that of the link, if it has one
  Wishes wishes;
  /** \brief Of a message, 1 KB … 4 GB; a server that sends more is left. */
  std::size_t most_bytes{std::size_t{256} << 20};
  std::uint32_t most_points{100'000'000};  ///< see FrameDecoder
  /** \brief File, PEM, of the certificates that are trusted; empty: those that the system trusts. For a certificate that a server made
   *  itself, that one. */
  std::string certificate_authority;
  bool verify{true};  ///< false: any certificate will do, and whoever is in between can read and change all
  bool reconnect{
      true};  ///< comes back by itself after the connection was lost, at once and then ever less often, up to every 10 seconds
  std::chrono::milliseconds connect_time{10'000};  ///< for all of a connection to be made, > 0
  /** \brief A server that sends nothing for so long, not even what a ping asks for, is gone; > 0. */
  std::chrono::milliseconds silence{20'000};
  int threads{0};  ///< that unpack frames; 0: one for each core
};

/** \brief A frame as it came. */
struct ReceivedFrame {
  std::vector<std::uint8_t> message;               ///< for FrameDecoder
  FrameTimes times;                                ///< by the server's clock
  std::int64_t arrived{0};                         ///< whole; nanoseconds since 1970 by this machine's clock
  std::shared_ptr<const Description> description;  ///< that held when it came; never null
};

struct ClientStatus {
  bool connected{false};
  bool ended{false};             ///< it will not connect any more: refused, or ClientOptions::reconnect is off
  std::string error;             ///< why it is not connected, one line; empty: no attempt has failed yet
  std::uint64_t connections{0};  ///< that were made
  std::uint64_t frames{0};       ///< that came
  std::uint64_t bytes{0};        ///< of them
  std::uint64_t dropped{0};      ///< frames that came, and that a newer one replaced before anybody pulled them
  std::uint64_t damaged{0};      ///< frames that could not be unpacked
};

/** \brief Receives what Server sends. It has a thread of its own, which answers frames as they arrive; every member may be called by any
 *  thread, but pull() by one at a time. */
class Client {
 public:
  /** \brief Connects from here on; whether that went well is in status() and takeNotices().
   *  \param link ws://, wss://, or http://, https:// as Server::link() has it; without a path, /stream
   *  \throws std::invalid_argument if it is no such link, or an option is out of its range; std::runtime_error if the file of certificates
   *  cannot be used */
  explicit Client(const std::string& link, const ClientOptions& options = {});
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  /** \brief The newest frame, if it was not pulled yet. False: none came in that time, or none will come any more, see status(). */
  bool pull(ReceivedFrame& frame, std::chrono::milliseconds timeout);
  bool pull(std::vector<std::uint8_t>& message, std::chrono::milliseconds timeout);
  /** \brief Unpacked. A frame that is damaged is counted, and said in a notice; the next one is waited for. */
  bool pull(StreamedCloud& cloud, std::chrono::milliseconds timeout);
  /** \brief The last one that came; an empty one before. */
  Description description() const;
  /** \brief Replaces ClientOptions::wishes; the server has them as soon as it can. \throws std::invalid_argument if a number is not finite,
   *  or a length not above 0 */
  void wish(const Wishes& wishes);

  ClientStatus status() const;
  /** \brief What happened since the last call, one line each: connected, lost, refused, and why. */
  std::vector<std::string> takeNotices();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace fuse_flow::stream
