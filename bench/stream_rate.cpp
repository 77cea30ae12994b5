// What clouds cost as bytes, and how long they take: fuse_flow_stream_bench CLOUD.ply…. Times are medians over all
// clouds, nine times each, on the cores that the process may use and on one.

#include "clouds/cloud_io.h"
#include "median.h"
#include "stream/codec/chunk_points.h"
#include "stream/codec/layers.h"

#include <fuse_flow/impl/host/parallel.hpp>
#include <fuse_flow/point_types.h>
#include <fuse_flow/stream/streamed_cloud.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

namespace {

using namespace fuse_flow;
using Cloud = pcl::PointCloud<PointFused>;

template <typename Action>
double milliseconds(const Action& action) {
  const auto start = std::chrono::steady_clock::now();
  action();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

/** \brief Least bits of bytes that are each coded by themselves. */
double entropy(const std::uint8_t* bytes, std::size_t count) {
  std::array<double, 256> counts{};
  for (std::size_t k = 0; k < count; ++k) ++counts[bytes[k]];
  double bits = 0;
  for (const double c : counts)
    if (c > 0) bits -= c * std::log2(c / static_cast<double>(count));
  return bits;
}

/** \brief Least bits of a frame's arrays, each with the one table that suits it best in each chunk and layer. */
double leastBits(const stream::EncodedFrame& frame) {
  const std::vector<std::uint8_t> message = stream::messageOf(std::make_shared<stream::EncodedFrame>(frame)).joined();
  stream::FrameDecoder decoder;
  stream::StreamedCloud cloud;
  decoder.decode(message.data(), message.size(), cloud);
  // Encoded again from the decoded chunks: the points of a chunk follow one another in its cloud.
  double bits = 0;
  std::size_t first = 0;
  for (const stream::EncodedChunk& chunk : frame.chunks) {
    stream::ChunkPoints points;
    points.resize(chunk.points, frame.fields);
    points.chroma = frame.chroma_step > 0;
    for (std::size_t k = 0; k < chunk.points; ++k) {
      for (std::size_t axis = 0; axis < 3; ++axis)
        points.positions[k][axis] = static_cast<std::uint32_t>(
            std::lround((cloud.positions[3 * (first + k) + axis] - frame.origin[axis]) / frame.step));
      points.codes[k] = stream::mortonCode(points.positions[k]);
      if (frame.fields & stream::kColor) {
        const std::uint8_t* rgb = &cloud.colors[3 * (first + k)];
        points.colors[k] = {{rgb[0], rgb[1], rgb[2]}};
        if (points.chroma) points.colors[k] = stream::toChroma(points.colors[k], frame.chroma_step);
      }
      if (frame.fields & stream::kConfidence) points.confidences[k] = cloud.confidence[first + k];
      if (frame.fields & stream::kViewCount) points.view_counts[k] = cloud.view_counts[first + k];
    }
    for (int layer = 0; layer < frame.layers; ++layer) {
      const std::size_t count = stream::Layer(layer, frame.layers).points(chunk.points);
      if (count == 0) continue;
      std::vector<std::uint8_t> bytes(stream::mostLayerBytes(count, frame.fields, frame.mask_bytes));
      std::vector<std::size_t> ends;
      stream::writeLayer(points, frame.fields, frame.mask_bytes, layer, frame.layers, bytes.data(), ends);
      const std::size_t raw = ends.size() > 1 ? ends[ends.size() - 2] : count;
      for (std::size_t begin = 0; begin + count <= raw; begin += count) bits += entropy(bytes.data() + begin, count);
      bits += 8.0 * static_cast<double>(ends.back() - raw);
    }
    first += chunk.points;
  }
  return bits;
}

void measure(const char* name, const std::vector<Cloud>& clouds, stream::EncodingOptions options) {
  double points = 0, bits = 0, least = 0;
  std::array<std::vector<double>, 2> encoding, decoding;  // on one core, on all
  for (const std::size_t all : {std::size_t{0}, std::size_t{1}}) {
    options.threads = all ? 0 : 1;
    stream::FrameEncoder encoder(options);
    stream::FrameDecoder decoder(options.threads);
    stream::StreamedCloud decoded;
    for (const Cloud& cloud : clouds)
      for (int repetition = 0; repetition < 10; ++repetition) {
        std::shared_ptr<const stream::EncodedFrame> frame;
        const double encode = milliseconds([&] { frame = encoder.encode(cloud, {}); });
        const std::vector<std::uint8_t> message = stream::messageOf(frame).joined();
        const double decode = milliseconds([&] { decoder.decode(message.data(), message.size(), decoded); });
        if (repetition == 0) {  // memory grows
          if (all == 0) continue;
          points += static_cast<double>(cloud.size());
          bits += 8.0 * static_cast<double>(message.size());
          least += leastBits(*frame);
          continue;
        }
        encoding[all].push_back(encode);
        decoding[all].push_back(decode);
      }
  }
  std::printf("%-44s %6.2f %6.2f   %6.1f %6.1f   %6.1f %6.1f\n", name, bits / points, least / points,
              bench::median(encoding[0]), bench::median(encoding[1]), bench::median(decoding[0]),
              bench::median(decoding[1]));
}

/** \brief What a client gets that takes a part of the points. */
void measureParts(const std::vector<Cloud>& clouds, const stream::EncodingOptions& options) {
  stream::FrameEncoder encoder(options);
  for (const double share : {0.5, 0.25, 0.125}) {
    double points = 0, bytes = 0;
    for (const Cloud& cloud : clouds) {
      const auto frame = encoder.encode(cloud, {});
      stream::Wishes wishes;
      wishes.points = static_cast<std::uint64_t>(share * static_cast<double>(cloud.size())) + 100;
      const stream::Selection part = stream::select(*frame, wishes);
      points += part.points;
      bytes += static_cast<double>(part.bytes);
    }
    const auto count = static_cast<double>(clouds.size());
    std::printf("%4.1f %% of the points: %.0f, %.2f bits a point, %.0f bytes\n", 100 * share, points / count,
                8 * bytes / points, bytes / count);
  }
}

int run(const std::vector<std::string>& paths) {
  std::vector<Cloud> clouds(paths.size());
  double points = 0;
  for (std::size_t k = 0; k < paths.size(); ++k) {
    io::readCloud(paths[k], clouds[k]);
    points += static_cast<double>(clouds[k].size());
  }
  std::printf(
      "%zu clouds of %.0f points; bits a point: as they are, and the least for what each byte tells; milliseconds\n",
      clouds.size(), points / static_cast<double>(clouds.size()));
  std::printf("%-44s %6s %6s   %6s %6s   %6s %6s\n", "", "bits", "least", "encode", "(all)", "decode", "(all)");
  stream::EncodingOptions color;
  color.confidence = color.view_count = false;
  measure("colour, step 1 mm", clouds, color);
  for (const int layers : {1, 2, 3, 5, 6}) {
    stream::EncodingOptions options = color;
    options.layers = layers;
    measure(("the same, " + std::to_string(layers) + (layers == 1 ? " layer" : " layers")).c_str(), clouds, options);
  }
  for (const int chunk : {8192, 16384, 65536}) {
    stream::EncodingOptions options = color;
    options.chunk_points = chunk;
    measure(("the same, chunks of " + std::to_string(chunk) + " points").c_str(), clouds, options);
  }
  for (const double step : {0.0005, 0.002, 0.004}) {
    stream::EncodingOptions options = color;
    options.step = step;
    char name[64];
    std::snprintf(name, sizeof name, "colour, step %.1f mm", 1e3 * step);
    measure(name, clouds, options);
  }
  for (const int chroma : {4, 8}) {
    stream::EncodingOptions options = color;
    options.chroma_step = chroma;
    measure(("colour, step 1 mm, chroma step " + std::to_string(chroma)).c_str(), clouds, options);
  }
  measure("colour, confidence, number of views", clouds, {});
  measureParts(clouds, color);
  return 0;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 2) {
    std::fprintf(stderr, "usage: fuse_flow_stream_bench CLOUD.ply…\n");
    return 2;
  }
  return run({argv + 1, argv + argc});
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
