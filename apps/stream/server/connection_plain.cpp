#include "stream/server/connection.h"
#include "stream/server/http_connection.h"

namespace fuse_flow::stream::network {

void beginConnection(net::ip::tcp::socket socket, std::shared_ptr<Gate> gate, Gate::Place place) {
  beast::error_code error;
  const net::ip::tcp::endpoint peer = socket.remote_endpoint(error);
  if (error) return;  // gone already
  tune(socket);
  const auto connection = std::make_shared<HttpConnection<ClientTcp>>(ClientTcp(std::move(socket)), textOf(peer),
                                                                      std::move(gate), std::move(place));
  net::post(connection->executor(), [connection] { connection->run(); });
}

}  // namespace fuse_flow::stream::network
