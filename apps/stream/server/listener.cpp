#include "stream/server/listener.h"

#include "stream/server/connection.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/address.hpp>
#include <boost/asio/ip/host_name.hpp>
#include <boost/asio/ip/v6_only.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/strand.hpp>
#include <boost/system/error_code.hpp>

#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>

#include <chrono>
#include <cstring>
#include <exception>
#include <stdexcept>
#include <thread>
#include <vector>

namespace fuse_flow::stream::network {

namespace net = boost::asio;
using boost::system::error_code;

namespace {

constexpr auto kRest = std::chrono::milliseconds(100);  // after an error that says that something is used up

[[noreturn]] void fail(const std::string& what) { throw std::runtime_error(what); }

std::shared_ptr<net::ssl::context> tlsOf(const Listener::Options& options) {
  if (options.certificate.empty()) return nullptr;
  auto tls = std::make_shared<net::ssl::context>(net::ssl::context::tls_server);
  tls->set_options(net::ssl::context::default_workarounds | net::ssl::context::no_sslv2 | net::ssl::context::no_sslv3 |
                   net::ssl::context::no_tlsv1 | net::ssl::context::no_tlsv1_1 | SSL_OP_NO_RENEGOTIATION);
  error_code error;
  tls->use_certificate_chain_file(options.certificate, error);
  if (error)
    fail(options.certificate + ": cannot be used, must be a file with a certificate, PEM (" + error.message() + ")");
  tls->use_private_key_file(options.key, net::ssl::context::pem, error);
  if (error)
    fail(options.key + ": cannot be used, must be a file with the key of " + options.certificate + ", PEM (" +
         error.message() + ")");
  if (SSL_CTX_check_private_key(tls->native_handle()) != 1)
    fail(options.key + ": is not the key of " + options.certificate);
  return tls;
}

net::ip::address addressOf(const std::string& text) {
  error_code error;
  const net::ip::address address = net::ip::make_address(text == "localhost" ? "127.0.0.1" : text, error);
  if (error)
    throw std::invalid_argument("stream::ServerOptions::address: '" + text +
                                "' is no IP address; must be as 127.0.0.1, or 0.0.0.0 for all of this machine's");
  return address;
}

}  // namespace

bool isLoopbackAddress(const std::string& text) {
  const net::ip::address address = addressOf(text);
  if (address.is_v6() && address.to_v6().is_v4_mapped())
    return net::ip::make_address_v4(net::ip::v4_mapped, address.to_v6()).is_loopback();
  return address.is_loopback();
}

std::string hostInLinks(const std::string& text) {
  const net::ip::address address = addressOf(text);
  if (!address.is_unspecified()) return address.is_v6() ? "[" + address.to_string() + "]" : address.to_string();
  std::string host;
  ifaddrs* all = nullptr;
  if (getifaddrs(&all) == 0) {
    for (const ifaddrs* each = all; each != nullptr && host.empty(); each = each->ifa_next) {
      if (each->ifa_addr == nullptr || each->ifa_addr->sa_family != AF_INET || (each->ifa_flags & IFF_UP) == 0)
        continue;
      sockaddr_in in{};
      std::memcpy(&in, each->ifa_addr, sizeof(in));
      const net::ip::address_v4 found(ntohl(in.sin_addr.s_addr));
      if (!found.is_loopback() && !found.is_unspecified()) host = found.to_string();
    }
    freeifaddrs(all);
  }
  error_code error;
  if (host.empty()) host = net::ip::host_name(error);
  return host.empty() ? "127.0.0.1" : host;
}

struct Listener::State {
  State(const Options& of, std::shared_ptr<Gate> to)
      : options(of),
        gate(std::move(to)),
        context(of.threads),
        tls(tlsOf(of)),
        strand(net::make_strand(context)),
        acceptor(strand),
        timer(strand) {
    const net::ip::tcp::endpoint endpoint(addressOf(options.address), options.port);
    const std::string name = hostOf(endpoint) + ":" + std::to_string(options.port);
    error_code error;
    const auto check = [&](const char* what) {
      if (error) fail(name + ": " + what + ": " + error.message());
    };
    acceptor.open(endpoint.protocol(), error);
    check("cannot be listened at");
    acceptor.set_option(net::socket_base::reuse_address(true), error);
    check("cannot be listened at");
    if (endpoint.address().is_v6() && endpoint.address().is_unspecified())
      acceptor.set_option(net::ip::v6_only(false), error);
    acceptor.bind(endpoint, error);
    check("cannot be listened at; must be an address of this machine, and a port that is free");
    acceptor.listen(net::socket_base::max_listen_connections, error);
    check("cannot be listened at; must be a port that is free");
    port = acceptor.local_endpoint(error).port();
    check("cannot be listened at");
  }

  static std::string hostOf(const net::ip::tcp::endpoint& endpoint) {
    const std::string address = endpoint.address().to_string();
    return endpoint.address().is_v6() ? "[" + address + "]" : address;
  }

  void accept() {
    const auto now = std::chrono::steady_clock::now();
    if (now - second >= std::chrono::seconds(1)) {
      second = now;
      in_this_second = 0;
    }
    if (in_this_second >= options.connections_per_second) return acceptAt(second + std::chrono::seconds(1));
    acceptor.async_accept(net::any_io_executor(net::make_strand(context)),
                          [this](error_code error, net::ip::tcp::socket socket) {
                            if (error) return failed(error);
                            ++in_this_second;
                            if (std::optional<Gate::Place> place = gate->admitConnection()) {
                              if (tls)
                                beginConnection(std::move(socket), *tls, gate, std::move(*place));
                              else
                                beginConnection(std::move(socket), gate, std::move(*place));
                            } else {
                              ++gate->refused;
                              if (now_and_then.due())
                                gate->notices.add("connections are refused: there are as many as may be");
                            }
                            accept();
                          });
  }

  void acceptAt(std::chrono::steady_clock::time_point time) {
    timer.expires_at(time);
    timer.async_wait([this](error_code error) {
      if (!error) accept();
    });
  }

  void failed(error_code error) {
    if (error == net::error::operation_aborted || !acceptor.is_open()) return;
    // One that went before it was let in is nothing; but where files or memory are used up, the next attempt would fail at once, again and
    // again.
    if (error == net::error::connection_aborted) return accept();
    if (now_and_then.due()) gate->notices.add("no connection can be accepted: " + error.message());
    acceptAt(std::chrono::steady_clock::now() + kRest);
  }

  void run() {
    for (;;) {
      try {
        context.run();
        return;
      } catch (const std::exception& error) {  // of one connection, as for want of memory; the others go on
        gate->notices.add(std::string("a connection failed: ") + error.what());
      }
    }
  }

  /** \brief True every ten seconds. */
  struct NowAndThen {
    std::chrono::steady_clock::time_point next;
    bool due() {
      const auto now = std::chrono::steady_clock::now();
      if (now < next) return false;
      next = now + std::chrono::seconds(10);
      return true;
    }
  };

  const Options options;
  const std::shared_ptr<Gate> gate;
  net::io_context context;
  const std::shared_ptr<net::ssl::context> tls;
  net::strand<net::io_context::executor_type> strand;
  net::ip::tcp::acceptor acceptor;
  net::steady_timer timer;
  std::chrono::steady_clock::time_point second;
  std::size_t in_this_second{0};
  NowAndThen now_and_then;
  std::uint16_t port{0};
  std::vector<std::thread> threads;
};

Listener::Listener(const Options& options, std::shared_ptr<Gate> gate) : state_(new State(options, std::move(gate))) {}

Listener::~Listener() {
  state_->context.stop();
  for (std::thread& thread : state_->threads) thread.join();
}

void Listener::start() {
  net::post(state_->strand, [state = state_.get()] { state->accept(); });
  for (int k = 0; k < state_->options.threads; ++k)
    state_->threads.emplace_back([state = state_.get()] { state->run(); });
}

void Listener::shut() {
  net::post(state_->strand, [state = state_.get()] {
    error_code ignored;
    state->acceptor.close(ignored);
    state->timer.cancel();
  });
}

std::uint16_t Listener::port() const { return state_->port; }

}  // namespace fuse_flow::stream::network
