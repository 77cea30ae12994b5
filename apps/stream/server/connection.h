#pragma once

#include "stream/server/gate.h"
#include "stream/server/session.h"

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>

#include <memory>

namespace fuse_flow::stream::network {

/** \brief Takes care of a connection that was accepted, on the executor of its socket, for as long as it lasts. \param place is given back
 *  when it ends */
void beginConnection(boost::asio::ip::tcp::socket socket, std::shared_ptr<Gate> gate, Gate::Place place);
/** \brief Likewise, by TLS. */
void beginConnection(boost::asio::ip::tcp::socket socket, boost::asio::ssl::context& tls, std::shared_ptr<Gate> gate,
                     Gate::Place place);

}  // namespace fuse_flow::stream::network
