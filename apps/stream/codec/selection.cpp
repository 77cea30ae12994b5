#include "stream/codec/frame_layout.h"
#include "stream/codec/layers.h"

#include <fuse_flow/stream/encoded_frame.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace fuse_flow::stream {

namespace {

/** \brief The box of a chunk in metres. */
Wishes::Box boxOf(const EncodedFrame& frame, const EncodedChunk& chunk) {
  Wishes::Box box{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.least[axis] = frame.origin[axis] + frame.step * chunk.least[axis];
    box.greatest[axis] = frame.origin[axis] + frame.step * chunk.greatest[axis];
  }
  return box;
}

bool meets(const Wishes::Box& a, const Wishes::Box& b) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (a.greatest[axis] < b.least[axis] || b.greatest[axis] < a.least[axis]) return false;
  return true;
}

double distanceTo(const Wishes::Box& box, const std::array<double, 3>& from) {
  double sum = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double outside = std::max({box.least[axis] - from[axis], from[axis] - box.greatest[axis], 0.0});
    sum += outside * outside;
  }
  return std::sqrt(sum);
}

/** \brief k / 2^bits with its bits reversed: any first part of 0, 1, 2, … is spread evenly over 0 … 1. */
double spreadEvenly(std::uint32_t k) {
  double value = 0, weight = 0.5;
  for (; k != 0; k >>= 1, weight /= 2)
    if (k & 1) value += weight;
  return value;
}

/** \brief One layer of one chunk, which may be taken if those before it were. */
struct Step {
  double order;
  std::uint32_t chunk;
  std::uint32_t points;
  std::size_t bytes;
};

}  // namespace

Selection select(const EncodedFrame& frame, const Wishes& wishes, std::size_t most_bytes) {
  Selection selection;
  selection.layers.assign(frame.chunks.size(), 0);
  selection.bytes = kHeaderBytes + kChecksumBytes;

  // A surface at twice the distance shows a quarter of its points on the same area of a picture: two layers less. As near as this all of
  // the cloud is as dense as it is.
  constexpr double near = 1;  // metre
  std::vector<Step> steps;
  for (std::uint32_t k = 0; k < frame.chunks.size(); ++k) {
    const EncodedChunk& chunk = frame.chunks[k];
    const Wishes::Box box = boxOf(frame, chunk);
    if (wishes.region && !meets(box, *wishes.region)) continue;
    double sparser = 0;
    if (wishes.viewpoint) sparser = 2 * std::log2(std::max(distanceTo(box, *wishes.viewpoint) / near, 1.0));
    for (std::uint32_t layer = 0; layer < chunk.layer_bytes.size(); ++layer) {
      if (layer > 0 && layer + sparser > frame.layers) break;
      // Each density comes for all chunks before the next one does for any, and in between for chunks that are spread over the scene.
      steps.push_back({layer + sparser + spreadEvenly(k), k, chunk.layer_points[layer],
                       chunk.layer_bytes[layer] + 4 + (layer == 0 ? kHeaderOfChunkBytes : 0)});
    }
  }
  std::stable_sort(steps.begin(), steps.end(), [](const Step& a, const Step& b) { return a.order < b.order; });
  for (const Step& step : steps) {
    if (wishes.points && selection.points + std::uint64_t{step.points} > *wishes.points) break;
    if (most_bytes > 0 && selection.bytes + step.bytes > most_bytes) break;
    ++selection.layers[step.chunk];
    selection.points += step.points;
    selection.bytes += step.bytes;
  }
  return selection;
}

std::size_t EncodedFrame::bytes() const {
  std::size_t sum = kHeaderBytes + kChecksumBytes;
  for (const EncodedChunk& chunk : chunks)
    sum += kHeaderOfChunkBytes + 4 * chunk.layer_bytes.size() + chunk.bytes.size();
  return sum;
}

Message messageOf(std::shared_ptr<const EncodedFrame> frame, const Selection& selection) {
  FrameHeader header;
  header.times = frame->times;
  header.origin = frame->origin;
  header.step = frame->step;
  header.fields = frame->fields;
  header.chroma_step = frame->chroma_step;
  header.layers = frame->layers;
  header.mask_bytes = frame->mask_bytes;
  header.points_of_frame = frame->points;
  header.points = selection.points;
  Message message;
  std::vector<std::size_t> at;  // of each chunk that is there, where its next layer lies
  for (std::uint32_t k = 0; k < frame->chunks.size(); ++k) {
    if (selection.layers[k] == 0) continue;
    const EncodedChunk& chunk = frame->chunks[k];
    ChunkHeader of_chunk{k, chunk.points, selection.layers[k], chunk.least, chunk.greatest, {}};
    std::copy_n(chunk.layer_bytes.begin(), of_chunk.layers, of_chunk.bytes.begin());
    header.chunks.push_back(of_chunk);
    at.push_back(0);
  }
  message.header = writeHeader(header);
  message.pieces.push_back({message.header.data(), message.header.size()});
  for (std::uint32_t layer = 0; layer < static_cast<std::uint32_t>(frame->layers); ++layer)
    for (std::size_t k = 0; k < header.chunks.size(); ++k) {
      const ChunkHeader& chunk = header.chunks[k];
      if (layer >= chunk.layers) continue;
      if (chunk.bytes[layer] > 0)
        message.pieces.push_back({frame->chunks[chunk.number].bytes.data() + at[k], chunk.bytes[layer]});
      at[k] += chunk.bytes[layer];
    }
  message.frame = std::move(frame);
  return message;
}

Message messageOf(std::shared_ptr<const EncodedFrame> frame) {
  const Selection all = select(*frame, {});
  return messageOf(std::move(frame), all);
}

std::shared_ptr<const EncodedFrame> frameOf(const std::uint8_t* data, std::size_t size) {
  FrameHeader header;
  readHeader(data, size, std::numeric_limits<std::uint32_t>::max(), header);
  auto frame = std::make_shared<EncodedFrame>();
  frame->times = header.times;
  frame->origin = header.origin;
  frame->step = header.step;
  frame->fields = header.fields;
  frame->chroma_step = header.chroma_step;
  frame->layers = header.layers;
  frame->mask_bytes = header.mask_bytes;
  frame->points = header.points_of_frame;
  for (const ChunkHeader& from : header.chunks) {
    EncodedChunk chunk;
    chunk.points = from.points;
    chunk.least = from.least;
    chunk.greatest = from.greatest;
    for (std::uint32_t layer = 0; layer < from.layers; ++layer) {
      chunk.layer_bytes.push_back(from.bytes[layer]);
      chunk.layer_points.push_back(
          static_cast<std::uint32_t>(Layer(static_cast<int>(layer), header.layers).points(from.points)));
    }
    frame->chunks.push_back(std::move(chunk));
  }
  const std::uint8_t* at = data + header.size;
  for (std::uint32_t layer = 0; layer < static_cast<std::uint32_t>(header.layers); ++layer)
    for (EncodedChunk& chunk : frame->chunks)
      if (layer < chunk.layer_bytes.size()) {
        chunk.bytes.insert(chunk.bytes.end(), at, at + chunk.layer_bytes[layer]);
        at += chunk.layer_bytes[layer];
      }
  return frame;
}

std::size_t Message::size() const {
  return std::accumulate(pieces.begin(), pieces.end(), std::size_t{0},
                         [](std::size_t sum, const Piece& piece) { return sum + piece.size; });
}

std::vector<std::uint8_t> Message::joined() const {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(size());
  for (const Piece& piece : pieces) bytes.insert(bytes.end(), piece.data, piece.data + piece.size);
  return bytes;
}

}  // namespace fuse_flow::stream
