#include "stream/network/client_connection.h"

#include "stream/network/streams.h"
#include "stream/network/text.h"

#include <boost/asio/buffer.hpp>
#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/host_name_verification.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <boost/beast/websocket/ssl.hpp>
#include <boost/beast/websocket/stream.hpp>

#include <openssl/err.h>
#include <openssl/ssl.h>

#include <algorithm>
#include <deque>
#include <optional>
#include <stdexcept>
#include <thread>
#include <type_traits>
#include <utility>

namespace fuse_flow::stream::network {

namespace websocket = beast::websocket;

namespace {

using Tcp = beast::tcp_stream;
using Tls = net::ssl::stream<Tcp>;

constexpr auto kFirstWait = std::chrono::milliseconds(200), kLongestWait = std::chrono::milliseconds(10'000);
constexpr auto kFarewell = std::chrono::milliseconds(300);
constexpr std::size_t kMostWaiting = 16;  // texts

/** \brief Why the certificate was refused, which the error of TLS does not say. */
std::string certificateError(SSL* ssl) {
  const long result = SSL_get_verify_result(ssl);
  return result == X509_V_OK ? "" : X509_verify_cert_error_string(result);
}

bool isAddress(const std::string& host) {
  beast::error_code error;
  net::ip::make_address(host, error);
  return !error;
}

}  // namespace

/** \brief One attempt, and the connection that comes of it. */
class Attempt {
 public:
  virtual ~Attempt() = default;
  virtual void begin() = 0;
  virtual void send(std::string kind, std::string text) = 0;
  /** \brief Says good-bye. */
  virtual void leave() = 0;
  /** \brief Ends without a word. */
  virtual void close() = 0;
};

struct ClientConnection::State {
  State(Options of, ClientEvents to)
      : options(std::move(of)),
        events(std::move(to)),
        tls(net::ssl::context::tls_client),
        resolver(context),
        timer(context) {
    if (!options.link.tls) return;
    tls.set_options(net::ssl::context::default_workarounds | net::ssl::context::no_sslv2 | net::ssl::context::no_sslv3 |
                    net::ssl::context::no_tlsv1 | net::ssl::context::no_tlsv1_1);
    beast::error_code error;
    if (!options.verify) {
      tls.set_verify_mode(net::ssl::verify_none);
      return;
    }
    tls.set_verify_mode(net::ssl::verify_peer);
    if (options.certificate_authority.empty()) {
      tls.set_default_verify_paths(error);
    } else {
      tls.load_verify_file(options.certificate_authority, error);
      if (error)
        throw std::runtime_error(options.certificate_authority +
                                 ": cannot be used, must be a file with certificates, PEM (" + error.message() + ")");
    }
  }

  void connect();
  /** \param final another attempt would end likewise */
  void lost(const std::string& error, bool final) {
    attempt.reset();
    const bool ends = final || !options.reconnect;
    events.lost(options.link.authority() + ": " + error, ends);
    if (ends || leaving) return;
    timer.expires_after(wait);
    wait = std::min<std::chrono::milliseconds>(2 * wait, kLongestWait);
    timer.async_wait([this](beast::error_code failed) {
      if (!failed && !leaving) connect();
    });
  }
  void opened() { events.opened(); }
  /** \brief What comes is in order: after the next loss it is tried again at once. */
  void goesWell() { wait = kFirstWait; }

  const Options options;
  const ClientEvents events;
  net::io_context context{1};
  net::ssl::context tls;
  net::ip::tcp::resolver resolver;
  net::steady_timer timer;
  std::shared_ptr<Attempt> attempt;
  std::chrono::milliseconds wait{kFirstWait};
  bool leaving{false};
  std::thread thread;
};

namespace {

template <typename Stream, typename State>
class AttemptBy : public Attempt, public std::enable_shared_from_this<AttemptBy<Stream, State>> {
 public:
  static constexpr bool kTls = !std::is_same_v<Stream, Tcp>;

  AttemptBy(State& state, Stream stream) : state_(state), web_socket_(std::move(stream)) {}

  void begin() override {
    const Link& link = state_.options.link;
    state_.resolver.async_resolve(link.host, link.port,
                                  [self = this->shared_from_this()](beast::error_code error, const auto& found) {
                                    if (error) return self->fail("the host is not known: " + error.message());
                                    self->connect(found);
                                  });
    // Of the resolver, which has no deadline of its own.
    deadline_.emplace(web_socket_.get_executor());
    deadline_->expires_after(state_.options.connect_time);
    deadline_->async_wait([self = this->shared_from_this()](beast::error_code error) {
      if (error || self->open_) return;
      self->state_.resolver.cancel();
      self->fail("there was no connection in " + std::to_string(self->state_.options.connect_time.count()) + " ms");
    });
  }

  void send(std::string kind, std::string text) override {
    if (!open_ || over_) return;
    if (!kind.empty())
      for (auto& waiting : waiting_)
        if (waiting.first == kind && &waiting != (writing_ ? &waiting_.front() : nullptr)) {
          waiting.second = std::move(text);
          return;
        }
    // A server that sends frames and takes no answers: it will find out itself.
    if (waiting_.size() >= kMostWaiting) return fail("it takes no answers");
    waiting_.emplace_back(std::move(kind), std::move(text));
    if (!writing_) write();
  }

  void close() override {
    over_ = true;
    deadline_.reset();
    beast::get_lowest_layer(web_socket_).close();
    if (state_.leaving) state_.context.stop();
  }

  void leave() override {
    if (!open_ || over_) return close();
    web_socket_.async_close(websocket::close_code::normal,
                            [self = this->shared_from_this()](beast::error_code) { self->close(); });
  }

 private:
  template <typename Endpoints>
  void connect(const Endpoints& endpoints) {
    if (over_) return;
    beast::get_lowest_layer(web_socket_).expires_after(state_.options.connect_time);
    beast::get_lowest_layer(web_socket_)
        .async_connect(endpoints, [self = this->shared_from_this()](beast::error_code error, const auto&) {
          if (error) return self->fail("cannot be connected to: " + error.message());
          tune(beast::get_lowest_layer(self->web_socket_).socket());
          self->secure();
        });
  }

  void secure() {
    if (over_) return;
    if constexpr (kTls) {
      Tls& tls = web_socket_.next_layer();
      const std::string& host = state_.options.link.host;
      if (!isAddress(host)) SSL_set_tlsext_host_name(tls.native_handle(), host.c_str());
      if (state_.options.verify) tls.set_verify_callback(net::ssl::host_name_verification(host));
      tls.async_handshake(net::ssl::stream_base::client, [self = this->shared_from_this()](beast::error_code error) {
        if (error) {
          const std::string why = certificateError(self->web_socket_.next_layer().native_handle());
          return self->fail(why.empty() ? "does not speak TLS: " + error.message()
                                        : "its certificate is not trusted: " + why);
        }
        self->shake();
      });
    } else {
      shake();
    }
  }

  void shake() {
    if (over_) return;
    beast::get_lowest_layer(web_socket_).expires_never();
    setTimeouts(state_.options.connect_time);
    web_socket_.read_message_max(state_.options.most_bytes);
    web_socket_.set_option(websocket::stream_base::decorator([this](websocket::request_type& request) {
      request.set(beast::http::field::user_agent, "fuse_flow");
      request.set(beast::http::field::sec_websocket_protocol, state_.options.subprotocol);
      if (!state_.options.token.empty())
        request.set(beast::http::field::authorization, "Bearer " + state_.options.token);
    }));
    web_socket_.async_handshake(response_, state_.options.link.authority(), state_.options.link.path,
                                [self = this->shared_from_this()](beast::error_code error) { self->shaken(error); });
  }

  void setTimeouts(std::chrono::milliseconds handshake) {
    websocket::stream_base::timeout timeout{};
    timeout.handshake_timeout = handshake;
    timeout.idle_timeout = state_.options.silence;
    timeout.keep_alive_pings = true;
    web_socket_.set_option(timeout);
  }

  void shaken(beast::error_code error) {
    if (over_) return;
    if (error == websocket::error::upgrade_declined) {
      const unsigned int status = response_.result_int();
      if (status == 401) return fail("the token is missing or wrong", true);
      if (status == 403) return fail("it lets this client not in (HTTP 403)", true);
      if (status == 503) return fail("it has too many clients");
      return fail("it is no server of streams: it answers HTTP " + std::to_string(status) + ", must be 101",
                  status == 400 || status == 404);
    }
    if (error) return fail("it is no server of streams: " + error.message());
    if (response_[beast::http::field::sec_websocket_protocol] != state_.options.subprotocol)
      return fail("it is no server of streams: it does not speak " + state_.options.subprotocol);
    open_ = true;
    deadline_->cancel();
    setTimeouts(kFarewell);  // of closing, from here on
    web_socket_.control_callback([this](websocket::frame_type type, beast::string_view) {
      if (type == websocket::frame_type::close) farewell();
    });
    state_.opened();
    read();
  }

  void read() {
    in_.clear();
    if (in_.capacity() > kKept) in_.shrink_to_fit();
    buffer_.emplace(in_, state_.options.most_bytes);
    web_socket_.async_read(*buffer_, [self = this->shared_from_this()](beast::error_code error, std::size_t) {
      if (self->over_) return;
      if (error) return self->endOf(error);
      try {
        if (self->web_socket_.got_binary())
          self->state_.events.binary(std::move(self->in_));
        else
          self->state_.events.text(std::string(self->in_.begin(), self->in_.end()));
      } catch (const std::exception& wrong) {
        return self->fail(std::string("it sent what is no stream: ") + printable(wrong.what(), 200));
      }
      self->state_.goesWell();
      self->read();
    });
  }

  /** \brief The server has said good-bye; the connection ends, whether it hangs up or not. */
  void farewell() {
    if (over_) return;
    deadline_->expires_after(kFarewell);
    deadline_->async_wait([self = this->shared_from_this()](beast::error_code error) {
      if (!error) self->endOf(websocket::error::closed);
    });
  }

  void endOf(beast::error_code error) {
    if (error == websocket::error::closed) {
      const websocket::close_reason& why = web_socket_.reason();
      if (why.code == websocket::close_code::going_away) return fail("the server has ended");
      return fail("the server has closed the connection, " + std::to_string(why.code) + " '" +
                  printable({why.reason.data(), why.reason.size()}) + "'");
    }
    if (error == websocket::error::message_too_big || error == websocket::error::buffer_overflow)
      return fail("it sent a message of more than " + std::to_string(state_.options.most_bytes) + " bytes");
    if (error == beast::error::timeout) return fail("it is silent");
    // What was wrong is lost where the server does not hang up then.
    if (error == net::error::bad_descriptor)
      return fail("it sent what is no WebSocket protocol, or a message of more than " +
                  std::to_string(state_.options.most_bytes) + " bytes");
    fail("the connection was lost: " + error.message());
  }

  void write() {
    writing_ = true;
    web_socket_.text(true);
    web_socket_.async_write(net::buffer(waiting_.front().second),
                            [self = this->shared_from_this()](beast::error_code error, std::size_t) {
                              self->writing_ = false;
                              self->waiting_.pop_front();
                              if (error || self->over_) return;  // reading says why
                              if (!self->waiting_.empty()) self->write();
                            });
  }

  void fail(const std::string& why, bool final = false) {
    if (over_) return;
    close();
    state_.lost(why, final);
  }

  static constexpr std::size_t kKept = std::size_t{1} << 20;  // bytes

  State& state_;
  websocket::stream<Stream> web_socket_;
  websocket::response_type response_;
  std::optional<net::steady_timer> deadline_;
  std::vector<std::uint8_t> in_;
  std::optional<net::dynamic_vector_buffer<std::uint8_t, std::allocator<std::uint8_t>>> buffer_;
  std::deque<std::pair<std::string, std::string>> waiting_;
  bool open_{false}, over_{false}, writing_{false};
};

}  // namespace

void ClientConnection::State::connect() {
  if (options.link.tls)
    attempt = std::make_shared<AttemptBy<Tls, State>>(*this, Tls(Tcp(context), tls));
  else
    attempt = std::make_shared<AttemptBy<Tcp, State>>(*this, Tcp(context));
  attempt->begin();
}

ClientConnection::ClientConnection(const Options& options, ClientEvents events)
    : state_(new State(options, std::move(events))) {}

void ClientConnection::start() {
  net::post(state_->context, [state = state_.get()] { state->connect(); });
  state_->thread = std::thread([state = state_.get()] {
    for (;;) {
      try {
        state->context.run();
        return;
      } catch (const std::exception& error) {  // as for want of memory
        if (state->attempt) state->attempt->close();
        state->lost(std::string("failed: ") + error.what(), false);
      }
    }
  });
}

ClientConnection::~ClientConnection() {
  if (state_->thread.joinable()) {
    net::post(state_->context, [state = state_.get()] {
      state->leaving = true;
      state->resolver.cancel();
      state->timer.expires_after(kFarewell);
      state->timer.async_wait([state](beast::error_code) { state->context.stop(); });
      if (state->attempt)
        state->attempt->leave();
      else
        state->context.stop();
    });
    state_->thread.join();
  }
  state_->attempt.reset();
}

void ClientConnection::send(std::string kind, std::string text) {
  net::post(state_->context, [state = state_.get(), kind = std::move(kind), text = std::move(text)]() mutable {
    if (state->attempt) state->attempt->send(std::move(kind), std::move(text));
  });
}

}  // namespace fuse_flow::stream::network
