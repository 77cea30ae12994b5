#pragma once

#include "stream/network/web_socket.h"

#include <boost/beast/core/bind_handler.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/span_body.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/http/write.hpp>

#include <array>
#include <type_traits>

namespace fuse_flow::stream::network {

/** \brief A connection to a client until it ends, or becomes a WebSocket: answers requests for files. It lives as long as something is
 *  under way. */
template <typename Stream>
class HttpConnection : public std::enable_shared_from_this<HttpConnection<Stream>> {
 public:
  HttpConnection(Stream stream, std::string address, std::shared_ptr<Gate> gate, Gate::Place place)
      : gate_(std::move(gate)), place_(std::move(place)), address_(std::move(address)), stream_(std::move(stream)) {}

  net::any_io_executor executor() { return stream_.get_executor(); }

  void run() {
    // Frames are hundreds of times what clients have to say.
    beast::get_lowest_layer(stream_).rate_policy().read_limit(kMostReadPerSecond);
    if constexpr (kTls) {
      beast::get_lowest_layer(stream_).expires_after(gate_->limits.handshake_time);
      stream_.async_handshake(net::ssl::stream_base::server,
                              [self = this->shared_from_this()](beast::error_code error) {
                                if (!error) self->readRequest();
                              });
    } else {
      readRequest();
    }
  }

 private:
  static constexpr bool kTls = !std::is_same_v<Stream, ClientTcp>;
  static constexpr std::size_t kMostReadPerSecond = 128 << 10;  // bytes
  static constexpr int kMostRequests = 100;                     // on one connection

  using Empty = http::request_parser<http::empty_body>;

  void readRequest() {
    parser_.emplace();
    parser_->header_limit(static_cast<std::uint32_t>(gate_->limits.header_bytes));
    // For all of it, so that a client which sends a byte now and then gains nothing.
    beast::get_lowest_layer(stream_).expires_after(gate_->limits.handshake_time);
    http::async_read_header(
        stream_, in_, *parser_,
        [self = this->shared_from_this()](beast::error_code error, std::size_t) { self->haveRequest(error); });
  }

  void haveRequest(beast::error_code error) {
    if (error == http::error::header_limit || error == http::error::buffer_overflow)
      return refuse(http::status::request_header_fields_too_large, "the header is too long");
    if (error == http::error::end_of_stream) return hangUp();
    if (error && error.category() == make_error_code(http::error::bad_target).category())
      return refuse(http::status::bad_request, "this is no HTTP request");
    if (error) return;  // gone, or too slow
    const auto& request = parser_->get();
    if (++requests_ >= kMostRequests) last_ = true;
    if (!request.keep_alive()) last_ = true;
    const bool has_body = parser_->chunked() || (parser_->content_length() && *parser_->content_length() > 0);
    if (has_body) return refuse(http::status::bad_request, "a request must have no body");
    const beast::string_view target = request.target();
    if (target.empty() || target.front() != '/')
      return refuse(http::status::bad_request, "the target must begin with /");
    const std::size_t query = std::min(target.find('?'), target.size());
    path_.assign(target.data(), query);
    const auto view = [](beast::string_view text) { return std::string_view(text.data(), text.size()); };
    // Of several headers of one name each reader may take another one.
    for (const http::field field : {http::field::host, http::field::origin, http::field::authorization})
      if (request.count(field) > 1) return refuse(http::status::bad_request, "a header is there twice");
    const Credentials who{view(request[http::field::host]), view(request[http::field::origin]),
                          view(request[http::field::authorization]),
                          view(target.substr(std::min(query + 1, target.size())))};
    if (who.host.empty()) return refuse(http::status::bad_request, "the header Host is missing");
    if (!gate_->access.mayAsk(who))
      return refuse(http::status::forbidden,
                    "the name of the server must be localhost, a loopback address, or an allowed host");
    if (websocket::is_upgrade(request)) return upgrade(who);
    answer(request, who);
  }

  void upgrade(const Credentials& who) {
    const auto& request = parser_->get();
    const Subprotocol* subprotocol = nullptr;
    bool here = false;
    for (const Subprotocol& each : gate_->subprotocols) {
      if (!each.path.empty() && each.path != path_) continue;
      here = true;
      for (const auto& wanted : http::token_list(request[http::field::sec_websocket_protocol]))
        if (!subprotocol && wanted == each.name) subprotocol = &each;
    }
    if (!here) return refuse(http::status::not_found, "there is nothing here");
    if (!gate_->access.mayConnectFrom(who))
      return refuse(
          http::status::forbidden,
          "the page must come from this server, or from an allowed origin; it is of '" + printable(who.origin) + "'");
    if (!gate_->access.hasToken(who)) return refuse(http::status::unauthorized, "the token is missing or wrong");
    if (!subprotocol) {
      std::string names;
      for (const Subprotocol& each : gate_->subprotocols)
        if (each.path.empty() || each.path == path_) names += (names.empty() ? "" : " or ") + each.name;
      return refuse(http::status::bad_request, "the WebSocket's subprotocol must be " + names);
    }
    if (in_.size() > 0) return refuse(http::status::bad_request, "nothing may be sent before the answer");
    std::optional<Gate::Place> client = gate_->admitClient();
    if (!client) return refuse(http::status::service_unavailable, "there are too many clients");
    // The stream does not hold what it had for HTTP any more: a deadline of its own begins.
    std::make_shared<WebSocket<Stream>>(std::move(stream_), std::move(address_), gate_, std::move(place_),
                                        std::move(*client))
        ->run(parser_->get(), *subprotocol);
  }

  void answer(const http::request<http::empty_body>& request, const Credentials& who) {
    const bool head = request.method() == http::verb::head;
    if (request.method() != http::verb::get && !head)
      return refuse(http::status::method_not_allowed, "the method must be GET or HEAD");
    if (path_ == "/healthz") return write(text(http::status::ok, "ok"), head);
    const std::shared_ptr<const HeldFile> file = gate_->file(path_);
    if (!file) {
      for (const Subprotocol& each : gate_->subprotocols)
        if (each.path == path_) return refuse(http::status::upgrade_required, "here is a WebSocket, of " + each.name);
      return write(text(http::status::not_found, "there is nothing here"), head);
    }
    http::response<http::span_body<const char>> response{http::status::ok, 11};
    response.set(http::field::content_type, file->content_type);
    response.set("Content-Security-Policy", file->policy.empty() ? usualPolicy(who.host) : file->policy);
    response.body() = beast::span<const char>(file->bytes.data(), file->bytes.size());
    write(std::move(response), head, file);
  }

  /** \brief 'self' is not the server's WebSockets to every browser, so they are named. The host is what the client wrote. */
  static std::string usualPolicy(std::string_view host) {
    std::string sockets;
    const bool plain = std::all_of(host.begin(), host.end(), [](char c) {
      return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' || c == '-' ||
             c == ':' || c == '[' || c == ']';
    });
    if (plain && host.size() <= 255) sockets = (kTls ? " wss://" : " ws://") + std::string(host);
    return "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; style-src 'self'; "
           "img-src 'self' data: blob:; "
           "connect-src 'self'" +
           sockets + "; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
  }

  static http::response<http::string_body> text(http::status status, const std::string& line) {
    http::response<http::string_body> response{status, 11};
    response.set(http::field::content_type, "text/plain; charset=utf-8");
    response.set("Content-Security-Policy", "default-src 'none'; frame-ancestors 'none'");
    response.body() = line + "\n";
    return response;
  }

  /** \brief The connection ends with it: who tries many things has to connect for each, and connections are counted. */
  void refuse(http::status status, const std::string& reason) {
    ++gate_->refused;
    gate_->notices.add(address_ + " was refused: " + reason);
    last_ = true;
    http::response<http::string_body> response = text(status, reason);
    if (status == http::status::unauthorized) response.set(http::field::www_authenticate, "Bearer");
    if (status == http::status::method_not_allowed) response.set(http::field::allow, "GET, HEAD");
    if (status == http::status::upgrade_required) {
      response.set(http::field::upgrade, "websocket");
      response.set(http::field::connection, "upgrade");
    }
    write(std::move(response), parser_ && parser_->get().method() == http::verb::head);
  }

  template <typename Body>
  void write(http::response<Body> response, bool head, std::shared_ptr<const void> held = nullptr) {
    response.set(http::field::server, "fuse_flow");
    response.set(http::field::cache_control, "no-store");
    response.set("X-Content-Type-Options", "nosniff");
    response.set("Referrer-Policy", "no-referrer");  // which would tell the token that is in the link
    response.set("Cross-Origin-Resource-Policy", "same-origin");
    response.keep_alive(!last_);
    response.prepare_payload();
    beast::get_lowest_layer(stream_).expires_after(std::chrono::seconds(30));
    const auto written = [self = this->shared_from_this(), held = std::move(held)](beast::error_code error,
                                                                                   std::size_t) {
      if (error) return;
      if (self->last_) return self->hangUp();
      self->readRequest();
    };
    if (head) {  // as for GET, without what it would be
      const auto header = std::make_shared<http::response<http::empty_body>>(std::move(response.base()));
      http::async_write(stream_, *header,
                        [header, written](beast::error_code error, std::size_t size) { written(error, size); });
      return;
    }
    const auto whole = std::make_shared<http::response<Body>>(std::move(response));
    http::async_write(stream_, *whole,
                      [whole, written](beast::error_code error, std::size_t size) { written(error, size); });
  }

  /** \brief Says that nothing more comes, and waits a little until the client has read it: what it still sends would else have the kernel
   *  throw the answer away. */
  void hangUp() {
    beast::error_code ignored;
    beast::get_lowest_layer(stream_).socket().shutdown(net::ip::tcp::socket::shutdown_send, ignored);
    beast::get_lowest_layer(stream_).expires_after(std::chrono::seconds(1));
    drain(0);
  }
  void drain(std::size_t bytes) {
    if (bytes > sizeof(rest_) * 64) return;
    beast::get_lowest_layer(stream_).async_read_some(
        net::buffer(rest_), [self = this->shared_from_this(), bytes](beast::error_code error, std::size_t more) {
          if (!error) self->drain(bytes + more);
        });
  }

  const std::shared_ptr<Gate> gate_;
  Gate::Place place_;
  std::string address_;
  Stream stream_;
  beast::flat_buffer in_{std::size_t{1} << 20};
  std::optional<Empty> parser_;
  std::string path_;
  int requests_{0};
  bool last_{false};
  std::array<char, 1024> rest_;
};

}  // namespace fuse_flow::stream::network
