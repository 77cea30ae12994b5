#include "stream/codec/chunk_points.h"
#include "stream/codec/frame_layout.h"
#include "stream/codec/sorted_points.h"
#include "stream/codec/zstandard.h"

#include <fuse_flow/impl/host/parallel.hpp>
#include <fuse_flow/stream/encoded_frame.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <stdexcept>
#include <string>

namespace fuse_flow::stream {

namespace {

void requireBetween(const char* name, int value, int least, int most) {
  if (value < least || value > most)
    throw std::invalid_argument("stream::EncodingOptions::" + std::string(name) + ": " + std::to_string(value) +
                                " is not between " + std::to_string(least) + " and " + std::to_string(most));
}

std::uint64_t maskOf(const CloudView& cloud, std::size_t point) {
  const auto* words = cloud.field<std::uint32_t>(cloud.camera_mask, point);
  return words[0] | static_cast<std::uint64_t>(words[1]) << 32;
}

/** \brief Bytes that the largest mask needs, 1 at least. */
int maskBytes(const CloudView& cloud, int threads) {
  std::atomic<std::uint64_t> used{0};
  constexpr std::size_t block = 65536;
  host::parallelFor(threads, (cloud.size + block - 1) / block, [&](std::size_t task, int) {
    std::uint64_t bits = 0;
    for (std::size_t i = task * block; i < std::min(cloud.size, (task + 1) * block); ++i) bits |= maskOf(cloud, i);
    used |= bits;
  });
  return std::max(1, (bitLength(used) + 7) / 8);
}

/** \brief The points of a chunk, with what is stored of their fields. */
void gatherChunk(const CloudView& cloud, const SortedPoints::Entry* entries, std::size_t count, std::uint32_t fields,
                 int chroma_step, ChunkPoints& chunk, EncodedChunk& to) {
  chunk.resize(count, fields);
  chunk.chroma = chroma_step > 0;
  to.points = static_cast<std::uint32_t>(count);
  const Lattice first = fromMortonCode(entries[0].code);
  for (std::size_t axis = 0; axis < 3; ++axis) to.least[axis] = to.greatest[axis] = first[axis];
  for (std::size_t k = 0; k < count; ++k) {
    // They lie anywhere in the cloud.
    constexpr std::size_t ahead = 12;
    if (k + ahead < count) __builtin_prefetch(cloud.points + entries[k + ahead].point * cloud.stride);
    const std::size_t point = entries[k].point;
    chunk.codes[k] = entries[k].code;
    const Lattice position = fromMortonCode(entries[k].code);
    chunk.positions[k] = position;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      to.least[axis] = std::min(to.least[axis], position[axis]);
      to.greatest[axis] = std::max(to.greatest[axis], position[axis]);
    }
    if (fields & kColor) {
      const auto* bgr = cloud.field<std::uint8_t>(cloud.color, point);
      const Triple rgb{{bgr[2], bgr[1], bgr[0]}};
      chunk.colors[k] = chroma_step > 0 ? toChroma(rgb, chroma_step) : rgb;
    }
    if (fields & kConfidence) chunk.confidences[k] = confidenceByte(*cloud.field<float>(cloud.confidence, point));
    if (fields & kViewCount) chunk.view_counts[k] = viewCountByte(*cloud.field<std::uint32_t>(cloud.view_count, point));
    if (fields & kNormal) chunk.normals[k] = toOctahedral(cloud.field<float>(cloud.normal, point));
    if (fields & kCameras) chunk.masks[k] = maskOf(cloud, point);
  }
}

}  // namespace

struct FrameEncoder::Workspace {
  /** \brief What a thread keeps from one chunk to the next. */
  struct Thread {
    ChunkPoints points;
    std::vector<std::uint8_t> layer;
    std::vector<std::size_t> ends;
    Compressor compressor;
  };

  EncodingOptions options;
  SortedPoints sorted;
  std::vector<Thread> threads;
};

FrameEncoder::FrameEncoder(const EncodingOptions& options) : workspace_(new Workspace) {
  if (!(options.step > 0) || !std::isfinite(options.step))
    throw std::invalid_argument("stream::EncodingOptions::step: " + std::to_string(options.step) +
                                " is not a length above 0, in metres");
  requireBetween("chroma_step", options.chroma_step, 0, kMostChromaStep);
  requireBetween("layers", options.layers, 1, kMostLayers);
  requireBetween("chunk_points", options.chunk_points, 64, static_cast<int>(kMostChunkPoints));
  workspace_->options = options;
}

FrameEncoder::~FrameEncoder() = default;

const EncodingOptions& FrameEncoder::options() const { return workspace_->options; }

std::shared_ptr<const EncodedFrame> FrameEncoder::encode(const CloudView& cloud, const FrameTimes& times) {
  Workspace& work = *workspace_;
  const EncodingOptions& options = work.options;
  const int threads = host::resolveThreads(options.threads);
  work.sorted.sort(cloud, options.step, threads);
  const std::vector<SortedPoints::Entry>& entries = work.sorted.entries();

  auto frame = std::make_shared<EncodedFrame>();
  frame->times = times;
  frame->origin = work.sorted.origin();
  frame->step = options.step;
  frame->fields = fieldsOf(cloud, options);
  frame->chroma_step = frame->fields & kColor ? options.chroma_step : 0;
  frame->layers = options.layers;
  frame->mask_bytes = frame->fields & kCameras ? maskBytes(cloud, threads) : 0;
  frame->points = static_cast<std::uint32_t>(entries.size());
  frame->left_out = work.sorted.leftOut();
  frame->too_far = work.sorted.tooFar();

  const auto of_chunk = static_cast<std::size_t>(options.chunk_points);
  frame->chunks.resize((entries.size() + of_chunk - 1) / of_chunk);
  if (work.threads.size() < static_cast<std::size_t>(threads)) work.threads.resize(static_cast<std::size_t>(threads));
  host::parallelFor(threads, frame->chunks.size(), [&](std::size_t number, int thread) {
    Workspace::Thread& mine = work.threads[static_cast<std::size_t>(thread)];
    EncodedChunk& chunk = frame->chunks[number];
    const std::size_t first = number * of_chunk, count = std::min(of_chunk, entries.size() - first);
    gatherChunk(cloud, &entries[first], count, frame->fields, frame->chroma_step, mine.points, chunk);
    std::vector<std::uint8_t>& bytes = mine.compressor.begin();
    for (int layer = 0; layer < options.layers; ++layer) {
      const std::size_t points = Layer(layer, options.layers).points(count), before = bytes.size();
      if (points > 0) {
        mine.layer.resize(mostLayerBytes(points, frame->fields, frame->mask_bytes));
        writeLayer(mine.points, frame->fields, frame->mask_bytes, layer, options.layers, mine.layer.data(), mine.ends);
        mine.compressor.append(mine.layer.data(), mine.ends);
      }
      chunk.layer_points.push_back(static_cast<std::uint32_t>(points));
      chunk.layer_bytes.push_back(static_cast<std::uint32_t>(bytes.size() - before));
    }
    chunk.bytes = bytes;
  });
  return frame;
}

}  // namespace fuse_flow::stream
