#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/beast/core/basic_stream.hpp>
#include <boost/beast/core/rate_policy.hpp>

#ifdef __linux__
#include <netinet/tcp.h>
#endif

#include <string>

namespace fuse_flow::stream::network {

namespace net = boost::asio;
namespace beast = boost::beast;

/** \brief A connection to a client: of what it sends, no more than so much is read in a second, whatever it is. */
using ClientTcp = beast::basic_stream<net::ip::tcp, net::any_io_executor, beast::simple_rate_policy>;
using ClientTls = net::ssl::stream<ClientTcp>;

/** \brief Frames go out as soon as they are there, and do not wait in the kernel behind others: what has not been sent stays with us, but for
 *  this much. (Not a small send buffer: that would limit what is under way, and so the rate over long distances.) */
template <typename Socket>
void tune(Socket& socket) {
  beast::error_code ignored;
  socket.set_option(net::ip::tcp::no_delay(true), ignored);
  socket.set_option(net::socket_base::keep_alive(true), ignored);
#ifdef TCP_NOTSENT_LOWAT
  socket.set_option(net::detail::socket_option::integer<IPPROTO_TCP, TCP_NOTSENT_LOWAT>(128 << 10), ignored);
#endif
}

inline std::string textOf(const net::ip::tcp::endpoint& endpoint) {
  const std::string address = endpoint.address().to_string();
  return (endpoint.address().is_v6() ? "[" + address + "]" : address) + ":" + std::to_string(endpoint.port());
}

}  // namespace fuse_flow::stream::network
