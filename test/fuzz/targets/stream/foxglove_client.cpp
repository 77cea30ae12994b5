#include "../../fuzz_target.h"

#include "stream/foxglove/client_requests.h"

#include <fuse_flow/stream/streamed_cloud.h>

/** \brief What Foxglove says to a server, as text and as bytes. */
FUSE_FLOW_FUZZ_TARGET(foxglove_client, 1 << 18, 512, 2000) {
  using namespace fuse_flow::stream;
  for (const bool binary : {false, true})
    fuse_flow_fuzz::accepts<FormatError>([&] { foxglove::clientRequest(input, binary); });
}
