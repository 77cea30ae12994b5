#include "../../fuzz_target.h"

#include <fuse_flow/distributed/camera_message.h>
#include <fuse_flow/distributed/gathered_cells.h>
#include <fuse_flow/distributed/part_summary.h>
#include <fuse_flow/point_types.h>

#if defined(FUSE_FLOW_WITH_ZSTD)
#include <fuse_flow/distributed/zstd_codec.h>
#endif

namespace {

using namespace fuse_flow::distributed;
using Cloud = pcl::PointCloud<fuse_flow::PointFused>;

constexpr std::size_t kCameras = 70;  // of more than one group

void readSummary(const Message& message) {
  PartSummary summary, again;
  if (!fuse_flow_fuzz::accepts<RankError>([&] { summary.read(message, 1, kCameras); })) return;
  Message written;
  summary.write(written);
  again.read(written, 1, kCameras);
  fuse_flow_fuzz::require(again.views.size() == summary.views.size() && again.blocks.size() == summary.blocks.size(),
                          "a summary that is read is not the one that is written");
}

void readCameras(const Message& message) {
  fuse_flow_fuzz::accepts<RankError>([&] {
    MessageReader in(message, 1);
    CameraMessage::get(in);
  });
}

void readGathered(const Message& message) {
  const GatheredCells own{{5, 1}};
  Cloud part, whole;
  part.resize(1);
  if (fuse_flow_fuzz::accepts<RankError>([&] { mergeGathered(own, part, {1}, {message}, whole); }))
    fuse_flow_fuzz::require(
        whole.size() * sizeof(fuse_flow::PointFused) <= message.size() + sizeof(fuse_flow::PointFused),
        "more points than came");
}

void readCoded(const Message& message) {
#if defined(FUSE_FLOW_WITH_ZSTD)
  constexpr std::size_t limit = 1 << 20;
  static const ZstdCodec codec;
  Message plain, coded, again;
  CodedMessage coding;
  if (!fuse_flow_fuzz::accepts<RankError>([&] { coding.decode(&codec, message, 1, limit, 1, plain); })) return;
  fuse_flow_fuzz::require(plain.size() <= limit, "more than the frame has");
  coding.code(codec, plain, {{plain.size() / 2, ByteKind::Words, 3}, {plain.size() / 3, ByteKind::Colors}}, 1, coded);
  coding.decode(&codec, coded, 1, limit, 1, again);
  fuse_flow_fuzz::require(again == plain, "other bytes after they were coded");
#else
  (void)message;
#endif
}

}  // namespace

/** \brief What a rank hears from another; the first byte says which of its messages. */
FUSE_FLOW_FUZZ_TARGET(rank_message, 8 << 20, 64, 3000) {
  if (input.empty()) return;
  const Message message(input.begin() + 1, input.end());
  switch (input[0] & 3) {
    case 0:
      return readSummary(message);
    case 1:
      return readCameras(message);
    case 2:
      return readGathered(message);
    default:
      return readCoded(message);
  }
}
