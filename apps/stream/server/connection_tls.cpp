#include "stream/server/connection.h"
#include "stream/server/http_connection.h"

namespace fuse_flow::stream::network {

namespace {

/** \brief A TLS stream that lives as long as what it was made from. */
ClientTls overTls(net::ip::tcp::socket socket, net::ssl::context& tls) { return {ClientTcp(std::move(socket)), tls}; }

}  // namespace

void beginConnection(net::ip::tcp::socket socket, net::ssl::context& tls, std::shared_ptr<Gate> gate,
                     Gate::Place place) {
  beast::error_code error;
  const net::ip::tcp::endpoint peer = socket.remote_endpoint(error);
  if (error) return;  // gone already
  tune(socket);
  const auto connection = std::make_shared<HttpConnection<ClientTls>>(overTls(std::move(socket), tls), textOf(peer),
                                                                      std::move(gate), std::move(place));
  net::post(connection->executor(), [connection] { connection->run(); });
}

}  // namespace fuse_flow::stream::network
