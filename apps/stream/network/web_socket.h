#pragma once

#include "stream/network/streams.h"
#include "stream/server/gate.h"
#include "stream/server/session.h"

#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <boost/beast/websocket/ssl.hpp>
#include <boost/beast/websocket/stream.hpp>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace fuse_flow::stream::network {

namespace http = beast::http;
namespace websocket = beast::websocket;

/** \brief A WebSocket to a client: reads its messages, few and small, and writes what its session sends. All of it but wake() and drop() runs on
 *  the executor of its socket, which is a strand. It lives as long as something is under way. */
template <typename Stream>
class WebSocket : public Channel, public std::enable_shared_from_this<WebSocket<Stream>> {
 public:
  WebSocket(Stream stream, std::string address, std::shared_ptr<Gate> gate, Gate::Place connection, Gate::Place client)
      : gate_(std::move(gate)),
        connection_(std::move(connection)),
        client_(std::move(client)),
        address_(std::move(address)),
        web_socket_(std::move(stream)),
        wake_timer_(web_socket_.get_executor()),
        close_timer_(web_socket_.get_executor()) {}

  void run(const http::request<http::empty_body>& request, const Subprotocol& subprotocol) {
    begin_ = subprotocol.begin;
    most_message_ = subprotocol.most_message;
    in_.max_size(2 * most_message_);
    beast::get_lowest_layer(web_socket_).expires_never();  // the WebSocket has its own
    setTimeouts(gate_->limits.handshake_time);
    web_socket_.set_option(
        websocket::stream_base::decorator([name = subprotocol.name](websocket::response_type& response) {
          response.set(http::field::server, "fuse_flow");
          response.set(http::field::sec_websocket_protocol, name);
        }));
    web_socket_.read_message_max(most_message_);
    web_socket_.auto_fragment(false);  // pieces go out as they are, in one frame
    web_socket_.control_callback(
        [this](websocket::frame_type type, beast::string_view payload) { heardControl(type, payload); });
    web_socket_.async_accept(request, [self = this->shared_from_this()](beast::error_code error) {
      if (error) return self->finish();
      self->setTimeouts(kFarewell);  // of closing, from here on
      self->session_ = self->begin_(self);
      self->session_->opened();
      self->read();
    });
  }

  // Channel
  void send(Outgoing message) override {
    if (closing_ || finished_) return;
    outgoing_ = std::move(message);
    buffers_.clear();
    for (const Outgoing::Piece& piece : outgoing_.pieces) buffers_.emplace_back(piece.data, piece.size);
    web_socket_.binary(outgoing_.binary);
    writing_ = true;
    web_socket_.async_write(buffers_, [self = this->shared_from_this()](beast::error_code error, std::size_t) {
      self->writing_ = false;
      self->outgoing_ = {};
      if (error) return self->finish();
      if (self->close_reason_) return self->writeClose();
      if (self->session_) self->session_->sent();
    });
  }

  void ping() override {
    // On a slow way the answer to the last one may take its time, and is worth waiting for.
    const auto now = std::chrono::steady_clock::now();
    if (pinging_ || closing_ || finished_ || (ping_sent_ && now - *ping_sent_ < kPingLost)) return;
    pinging_ = true;
    ping_number_ = std::to_string(std::stoul("0" + ping_number_) + 1);
    ping_sent_ = now;
    web_socket_.async_ping(websocket::ping_data(ping_number_.c_str()),
                           [self = this->shared_from_this()](beast::error_code) { self->pinging_ = false; });
  }

  void wakeAt(std::chrono::steady_clock::time_point time) override {
    if (finished_) return;
    wake_timer_.expires_at(time);
    wake_timer_.async_wait([self = this->shared_from_this()](beast::error_code error) {
      if (!error && self->session_ && !self->finished_) self->session_->woken();
    });
  }

  void close(CloseCode code, const std::string& reason) override {
    if (closing_ || finished_) return;
    closing_ = true;
    close_reason_.emplace(static_cast<websocket::close_code>(code),
                          beast::string_view(reason.data(), std::min<std::size_t>(reason.size(), 123)));
    wake_timer_.cancel();
    endSoon();
    if (!writing_) writeClose();
  }

  const std::string& address() const override { return address_; }

  void wake() override {
    if (woken_.exchange(true)) return;
    net::post(web_socket_.get_executor(), [self = this->shared_from_this()] {
      self->woken_ = false;
      if (self->session_ && !self->finished_) self->session_->woken();
    });
  }

  void drop() override {
    net::post(web_socket_.get_executor(), [self = this->shared_from_this()] { self->end(); });
  }

  void goAway() override {
    net::post(web_socket_.get_executor(),
              [self = this->shared_from_this()] { self->close(kGoingAway, "the server ends"); });
  }

 private:
  static constexpr std::chrono::milliseconds kFarewell{1000}, kPingLost{5000};

  void setTimeouts(std::chrono::milliseconds handshake) {
    websocket::stream_base::timeout timeout{};
    timeout.handshake_timeout = handshake;
    timeout.idle_timeout = websocket::stream_base::none();  // the session knows what to wait for
    timeout.keep_alive_pings = false;
    web_socket_.set_option(timeout);
  }

  void read() {
    web_socket_.async_read(in_, [self = this->shared_from_this()](beast::error_code error, std::size_t) {
      if (error) {
        self->tellOf(error);
        return self->finish();
      }
      if (!self->session_) return;
      if (self->mayGoOn()) {
        const auto bytes = self->in_.data();
        self->session_->received({static_cast<const char*>(bytes.data()), bytes.size()},
                                 self->web_socket_.got_binary());
      }
      self->in_.consume(self->in_.size());
      self->read();
    });
  }

  /** \brief Of what is no fault of the network. */
  void tellOf(beast::error_code error) {
    const bool too_big = error == websocket::error::message_too_big || error == websocket::error::buffer_overflow;
    if (finished_ || closing_ || error == websocket::error::closed ||
        !(too_big || error == websocket::condition::protocol_violation))
      return;
    ++gate_->dropped;
    gate_->notices.add("client " + address_ + " was let go: " +
                       (too_big ? "a message of more than " + std::to_string(most_message_) + " bytes"
                                : "what it sends is no WebSocket protocol"));
  }

  /** \brief Within the reading of what comes. */
  void heardControl(websocket::frame_type type, beast::string_view payload) {
    if (finished_ || !session_) return;
    if (type == websocket::frame_type::close) return endSoon();
    // What was asked for is not counted: who takes many frames a second answers many pings.
    if (type == websocket::frame_type::pong && ping_sent_ && payload == ping_number_ && !closing_)
      return session_->pong(std::chrono::steady_clock::now() - *std::exchange(ping_sent_, std::nullopt));
    mayGoOn();
  }

  /** \brief Counts what the client sends, and ends it if that is too much. */
  bool mayGoOn() {
    if (closing_ || finished_) return false;
    const auto now = std::chrono::steady_clock::now();
    if (now - second_ >= std::chrono::seconds(1)) {
      second_ = now;
      in_this_second_ = 0;
    }
    if (++in_this_second_ <= gate_->limits.messages_per_second) return true;
    ++gate_->dropped;
    gate_->notices.add("client " + address_ + " was let go: more than " +
                       std::to_string(gate_->limits.messages_per_second) + " messages a second");
    // Not here, where the stream is in the midst of reading.
    net::post(web_socket_.get_executor(),
              [self = this->shared_from_this()] { self->close(kPolicy, "too many messages a second"); });
    return false;
  }

  void writeClose() {
    const websocket::close_reason reason = *std::exchange(close_reason_, std::nullopt);
    web_socket_.async_close(reason, [self = this->shared_from_this()](beast::error_code) { self->finish(); });
  }

  /** \brief For good-byes that are said, whether the client hangs up or not. */
  void endSoon() {
    close_timer_.expires_after(kFarewell);
    close_timer_.async_wait([self = this->shared_from_this()](beast::error_code error) {
      if (!error) self->end();
    });
  }

  /** \brief Without waiting for anything; what the kernel still has of it is thrown away. */
  void end() {
    auto& socket = beast::get_lowest_layer(web_socket_).socket();
    beast::error_code ignored;
    socket.set_option(net::socket_base::linger(true, 0), ignored);
    beast::get_lowest_layer(web_socket_).close();
    finish();
  }

  void finish() {
    if (std::exchange(finished_, true)) return;
    wake_timer_.cancel();
    close_timer_.cancel();
    if (beast::get_lowest_layer(web_socket_).socket().is_open()) beast::get_lowest_layer(web_socket_).close();
    if (session_) session_->closed();
    // The session may be what has called; it goes when it has returned.
    net::post(web_socket_.get_executor(), [self = this->shared_from_this()] { self->session_.reset(); });
  }

  const std::shared_ptr<Gate> gate_;
  const Gate::Place connection_, client_;
  const std::string address_;
  websocket::stream<Stream> web_socket_;
  net::steady_timer wake_timer_, close_timer_;
  std::size_t most_message_{0};
  beast::flat_buffer in_;
  SessionFactory begin_;
  std::unique_ptr<Session> session_;
  Outgoing outgoing_;
  std::vector<net::const_buffer> buffers_;
  std::optional<websocket::close_reason> close_reason_;  ///< that is to be written
  bool writing_{false}, closing_{false}, finished_{false}, pinging_{false};
  std::string ping_number_;
  std::optional<std::chrono::steady_clock::time_point> ping_sent_;
  std::chrono::steady_clock::time_point second_;
  std::size_t in_this_second_{0};
  std::atomic<bool> woken_{false};
};

}  // namespace fuse_flow::stream::network
