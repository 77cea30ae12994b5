#include "../../fuzz_target.h"

#include <fuse_flow/stream/encoded_frame.h>
#include <fuse_flow/stream/streamed_cloud.h>

#include <zlib.h>

#include <cstring>

namespace {

using namespace fuse_flow::stream;
using Bytes = std::vector<std::uint8_t>;

/** \brief With the checksum that its header should have: without, hardly a mutation came past it. */
Bytes withChecksum(Bytes bytes) {
  std::uint32_t size = 0;
  if (bytes.size() < 8) return bytes;
  std::memcpy(&size, bytes.data() + 4, 4);
  if (size < 8 || size > bytes.size()) return bytes;
  const auto crc = static_cast<std::uint32_t>(crc32_z(0, bytes.data(), size - 4));
  std::memcpy(bytes.data() + size - 4, &crc, 4);
  return bytes;
}

void readFrame(const Bytes& bytes) {
  constexpr std::uint32_t most_points = 1 << 16;
  static FrameDecoder decoder(1, most_points);
  StreamedCloud cloud;
  const bool decoded = fuse_flow_fuzz::accepts<FormatError>([&] { decoder.decode(bytes.data(), bytes.size(), cloud); });
  if (decoded)
    fuse_flow_fuzz::require(cloud.size() <= most_points && cloud.size() <= cloud.points_of_frame,
                            "more points than it may have");
  // What a recorder's file is served from: a part of a frame again as a frame.
  std::shared_ptr<const EncodedFrame> frame;
  fuse_flow_fuzz::accepts<FormatError>([&] { frame = frameOf(bytes.data(), bytes.size()); });
  if (!frame) return;
  Wishes wishes;
  wishes.points = 100;
  wishes.viewpoint = {{0, 0, 0}};
  const Selection selection = select(*frame, wishes);
  const Message message = messageOf(frame, selection);
  fuse_flow_fuzz::require(message.size() == selection.bytes, "a message of another size than was chosen");
}

}  // namespace

/** \brief A frame from a server. Of one byte Zstandard makes up to 32 KiB; the decoder refuses more points than it takes, before it takes memory for them: 37
 *  bytes a point, 48 while its chunk is unpacked, and as much for the chunk's layers. */
FUSE_FLOW_FUZZ_TARGET(stream_frame, 24 << 20, 256, 2000) {
  const Bytes bytes(input.begin(), input.end());
  readFrame(bytes);
  readFrame(withChecksum(bytes));
}
