#include "../../fuzz_target.h"

#include "stream/server/client_messages.h"

#include <fuse_flow/stream/streamed_cloud.h>

/** \brief What a client says to a server. What is accepted can be said by our client, too, and then says the same. */
FUSE_FLOW_FUZZ_TARGET(stream_client, 1 << 18, 512, 2000) {
  using namespace fuse_flow::stream;
  fuse_flow_fuzz::accepts<FormatError>([&] {
    const auto written = [](const network::ClientMessage& message) {
      return std::visit([](const auto& some) { return network::toJson(some); }, message);
    };
    const std::string once = written(network::clientMessage(input));
    fuse_flow_fuzz::require(written(network::clientMessage(once)) == once,
                            "a message that is another one when it is sent again");
  });
}
