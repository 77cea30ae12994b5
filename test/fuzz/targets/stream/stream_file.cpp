#include "../../fuzz_target.h"
#include "../../scratch.h"

#include <fuse_flow/stream/stream_file.h>
#include <fuse_flow/stream/streamed_cloud.h>

/** \brief A stream file, of descriptions and frames. An entry of a frame is as small as its header. */
FUSE_FLOW_FUZZ_TARGET(stream_file, 1 << 18, 512, 1000) {
  using namespace fuse_flow::stream;
  const std::string path = fuse_flow_fuzz::scratchFile("stream.ffs", input);
  fuse_flow_fuzz::accepts<FormatError>([&] {
    StreamReader reader(path);
    std::vector<std::uint8_t> message;
    for (std::size_t frame = 0; frame < std::min<std::size_t>(3, reader.frames()); ++frame) {
      reader.read(frame, message);
      reader.time(frame);
    }
  });
}
