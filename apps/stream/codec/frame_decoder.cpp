#include "stream/codec/chunk_points.h"
#include "stream/codec/frame_layout.h"
#include "stream/codec/layers.h"
#include "stream/codec/zstandard.h"

#include <fuse_flow/impl/host/parallel.hpp>
#include <fuse_flow/stream/streamed_cloud.h>

namespace fuse_flow::stream {

struct FrameDecoder::Workspace {
  /** \brief What a thread keeps from one chunk to the next. */
  struct Thread {
    ChunkPoints points;
    std::vector<std::uint8_t> layer;
    Decompressor decompressor;
  };

  int threads;
  std::uint32_t most_points;
  FrameHeader header;
  std::vector<Thread> of_threads;
};

FrameDecoder::FrameDecoder(int threads, std::uint32_t most_points) : workspace_(new Workspace) {
  workspace_->threads = host::resolveThreads(threads);
  workspace_->most_points = most_points;
}

FrameDecoder::~FrameDecoder() = default;

void FrameDecoder::decode(const std::uint8_t* data, std::size_t size, StreamedCloud& cloud) {
  Workspace& work = *workspace_;
  FrameHeader& header = work.header;
  readHeader(data, size, work.most_points, header);
  const std::size_t chunks = header.chunks.size();

  // Where each layer lies, and where the points of each chunk go.
  std::vector<std::array<const std::uint8_t*, kMostLayers>> layers(chunks);
  const std::uint8_t* at = data + header.size;
  for (std::uint32_t layer = 0; layer < static_cast<std::uint32_t>(header.layers); ++layer)
    for (std::size_t k = 0; k < chunks; ++k)
      if (layer < header.chunks[k].layers) {
        layers[k][layer] = at;
        at += header.chunks[k].bytes[layer];
      }
  std::vector<std::size_t> first(chunks + 1, 0);
  for (std::size_t k = 0; k < chunks; ++k)
    first[k + 1] =
        first[k] + pointsUpTo(header.chunks[k].points, static_cast<int>(header.chunks[k].layers), header.layers);

  const std::size_t points = header.points;
  cloud.times = header.times;
  cloud.step = header.step;
  cloud.points_of_frame = header.points_of_frame;
  cloud.positions.resize(3 * points);
  cloud.colors.resize(header.fields & kColor ? 3 * points : 0);
  cloud.confidence.resize(header.fields & kConfidence ? points : 0);
  cloud.view_counts.resize(header.fields & kViewCount ? points : 0);
  cloud.normals.resize(header.fields & kNormal ? 3 * points : 0);
  cloud.camera_masks.resize(header.fields & kCameras ? points : 0);

  if (work.of_threads.size() < static_cast<std::size_t>(work.threads))
    work.of_threads.resize(static_cast<std::size_t>(work.threads));
  host::parallelFor(work.threads, chunks, [&](std::size_t k, int thread) {
    Workspace::Thread& mine = work.of_threads[static_cast<std::size_t>(thread)];
    const ChunkHeader& chunk = header.chunks[k];
    mine.points.resize(chunk.points, header.fields);
    mine.points.chroma = header.chroma_step > 0;
    for (std::uint32_t layer = 0; layer < chunk.layers; ++layer) {
      const std::size_t of_layer = Layer(static_cast<int>(layer), header.layers).points(chunk.points);
      if (of_layer == 0) continue;
      mine.layer.resize(mostLayerBytes(of_layer, header.fields, header.mask_bytes));
      const std::size_t unpacked = mine.decompressor.unpack(layers[k][layer], chunk.bytes[layer], mine.layer);
      readLayer(mine.layer.data(), unpacked, header.fields, header.mask_bytes, static_cast<int>(layer), header.layers,
                mine.points);
    }
    const std::size_t stride = std::size_t{1} << (static_cast<std::uint32_t>(header.layers) - chunk.layers);
    std::size_t to = first[k];
    for (std::size_t i = 0; i < chunk.points; i += stride, ++to) {
      for (std::size_t axis = 0; axis < 3; ++axis)
        cloud.positions[3 * to + axis] =
            static_cast<float>(header.origin[axis] + header.step * mine.points.positions[i][axis]);
      if (header.fields & kColor) {
        const Triple color =
            header.chroma_step > 0 ? fromChroma(mine.points.colors[i], header.chroma_step) : mine.points.colors[i];
        for (std::size_t part = 0; part < 3; ++part) cloud.colors[3 * to + part] = color[part];
      }
      if (header.fields & kConfidence) cloud.confidence[to] = mine.points.confidences[i];
      if (header.fields & kViewCount) cloud.view_counts[to] = mine.points.view_counts[i];
      if (header.fields & kNormal)
        fromOctahedral(mine.points.normals[i][0], mine.points.normals[i][1], &cloud.normals[3 * to]);
      if (header.fields & kCameras) cloud.camera_masks[to] = mine.points.masks[i];
    }
  });
}

}  // namespace fuse_flow::stream
