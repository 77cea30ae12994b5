#include "../../fuzz_target.h"

#include <fuse_flow/stream/description.h>
#include <fuse_flow/stream/streamed_cloud.h>

/** \brief What a server says of its stream: JSON, of which a value is some 40 bytes. What is read is written and read again. */
FUSE_FLOW_FUZZ_TARGET(stream_description, 1 << 18, 512, 2000) {
  using namespace fuse_flow::stream;
  fuse_flow_fuzz::accepts<FormatError>([&] {
    const std::string once = toJson(descriptionFromJson(std::string(input)));
    fuse_flow_fuzz::require(toJson(descriptionFromJson(once)) == once,
                            "a description that is another one when it is sent on");
  });
}
