#include "stream/foxglove/cloud_payload.h"

#include "stream/codec/layers.h"
#include "stream/foxglove/protobuf_writer.h"
#include "stream/network/text.h"

#include <algorithm>
#include <cstring>

namespace fuse_flow::stream::foxglove {

namespace {

// foxglove.PackedElementField.NumericType
constexpr std::uint64_t kUint8 = 1, kFloat32 = 7;

struct Column {
  const char* name;
  std::uint64_t type;
};

/** \brief How a point is packed: first position, then colour, then the rest, without gaps. */
std::vector<Column> columnsOf(std::uint32_t fields) {
  std::vector<Column> columns{{"x", kFloat32}, {"y", kFloat32}, {"z", kFloat32}};
  if (fields & kColor)
    for (const char* name : {"red", "green", "blue", "alpha"}) columns.push_back({name, kUint8});
  if (fields & kConfidence) columns.push_back({"confidence", kUint8});
  if (fields & kViewCount) columns.push_back({"view_count", kUint8});
  return columns;
}

std::uint8_t* pack(const StreamedCloud& cloud, std::size_t point, std::uint8_t* to) {
  std::memcpy(to, &cloud.positions[3 * point], 3 * sizeof(float));
  to += 3 * sizeof(float);
  if (!cloud.colors.empty()) {
    std::memcpy(to, &cloud.colors[3 * point], 3);
    to[3] = 255;
    to += 4;
  }
  if (!cloud.confidence.empty()) *to++ = cloud.confidence[point];
  if (!cloud.view_counts.empty()) *to++ = cloud.view_counts[point];
  return to;
}

}  // namespace

std::string CloudPayload::beginning(std::size_t layers) const {
  return head + ProtobufWriter().beginBytes(6, stride * up_to[layers - 1]).bytes();
}

CloudPayload CloudPayloads::make(const std::shared_ptr<const EncodedFrame>& encoded, const std::string& frame) {
  const std::vector<std::uint8_t> message = messageOf(encoded).joined();
  decoder_.decode(message.data(), message.size(), cloud_);

  CloudPayload payload;
  const FrameTimes& times = encoded->times;
  std::int64_t time = times.captured > 0 ? times.captured : times.encoded;
  if (time <= 0) time = network::nanosecondsSince1970();
  payload.time = static_cast<std::uint64_t>(time);

  ProtobufWriter head;
  head.time(1, payload.time).text(2, frame);
  head.message(3, ProtobufWriter()
                      .message(1, ProtobufWriter().real(1, 0).real(2, 0).real(3, 0))
                      .message(2, ProtobufWriter().real(1, 0).real(2, 0).real(3, 0).real(4, 1)));
  ProtobufWriter fields;
  for (const Column& column : columnsOf(encoded->fields)) {
    fields.message(5, ProtobufWriter()
                          .text(1, column.name)
                          .fixed32(2, static_cast<std::uint32_t>(payload.stride))
                          .whole(3, column.type));
    payload.stride += column.type == kFloat32 ? sizeof(float) : 1;
  }
  head.fixed32(4, static_cast<std::uint32_t>(payload.stride));
  payload.head = head.bytes() + fields.bytes();

  // Chunks come one after the other, each with those ranks that its layers have; see doc/reference/stream_format.md.
  payload.points.resize(payload.stride * cloud_.size());
  std::uint8_t* to = payload.points.data();
  const int layers = encoded->layers;
  std::size_t total = 0;
  for (int number = 0; number < layers; ++number) {
    const Layer layer(number, layers);
    std::size_t first = 0;
    for (const EncodedChunk& chunk : encoded->chunks) {
      const int here =
          static_cast<int>(std::min<std::size_t>(chunk.layer_points.size(), static_cast<std::size_t>(layers)));
      const std::size_t points = pointsUpTo(chunk.points, here, layers);
      if (first + points > cloud_.size()) throw FormatError("a frame has other points than its header says");
      if (number < here) {
        const int coarser = layers - here;
        for (std::size_t rank = layer.first; rank < chunk.points; rank += layer.between, ++total)
          to = pack(cloud_, first + (rank >> coarser), to);
      }
      first += points;
    }
    payload.up_to.push_back(static_cast<std::uint32_t>(total));
  }
  if (total != cloud_.size()) throw FormatError("a frame has other points than its header says");
  return payload;
}

}  // namespace fuse_flow::stream::foxglove
