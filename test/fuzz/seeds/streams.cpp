#include "../scratch.h"
#include "../seeds.h"

#include "recordings/files/file_io.h"

#include <fuse_flow/point_types.h>
#include <fuse_flow/stream/description.h>
#include <fuse_flow/stream/encoded_frame.h>
#include <fuse_flow/stream/stream_file.h>

#include <pcl/point_cloud.h>
#include <zlib.h>
#include <zstd.h>

#include <cstring>

namespace fuse_flow_fuzz {
namespace {

using namespace fuse_flow::stream;
using Bytes = std::vector<std::uint8_t>;

pcl::PointCloud<fuse_flow::PointFusedCameras> points() {
  pcl::PointCloud<fuse_flow::PointFusedCameras> cloud;
  for (int k = 0; k < 20; ++k) {
    fuse_flow::PointFusedCameras point;
    point.x = 0.01f * static_cast<float>(k % 5);
    point.y = 0.01f * static_cast<float>(k);
    point.z = 1;
    point.r = static_cast<std::uint8_t>(10 * k);
    point.confidence = 0.5f;
    point.view_count = 2;
    point.camera_mask[0] = 3;
    cloud.push_back(point);
  }
  return cloud;
}

/** \brief The same bytes in a block that is not compressed, without a checksum, so that mutations get to the points (RFC 8878). */
Bytes stored(const std::uint8_t* data, std::size_t size) {
  Bytes bytes(4096);  // more than twenty points have
  bytes.resize(ZSTD_decompress(bytes.data(), bytes.size(), data, size));
  const auto count = static_cast<std::uint32_t>(bytes.size());
  Bytes frame{0x28, 0xb5, 0x2f, 0xfd, 0xa0};  // one segment, whose size has 4 bytes
  for (int k = 0; k < 4; ++k) frame.push_back(static_cast<std::uint8_t>(count >> (8 * k)));
  const std::uint32_t block = count << 3 | 1;  // the last, raw
  for (int k = 0; k < 3; ++k) frame.push_back(static_cast<std::uint8_t>(block >> (8 * k)));
  frame.insert(frame.end(), bytes.begin(), bytes.end());
  return frame;
}

std::string asString(const Bytes& bytes) { return std::string(bytes.begin(), bytes.end()); }

Bytes encoded(const EncodingOptions& options, bool compressed) {
  FrameEncoder encoder(options);
  const auto frame = encoder.encode(points(), {3, 1'700'000'000'000'000'000, 1'700'000'000'010'000'000});
  if (compressed) return messageOf(frame).joined();
  auto plain = std::make_shared<EncodedFrame>(*frame);
  for (EncodedChunk& chunk : plain->chunks) {
    Bytes all;
    std::size_t at = 0;
    for (std::uint32_t& size : chunk.layer_bytes) {
      const Bytes layer = size > 0 ? stored(chunk.bytes.data() + at, size) : Bytes();
      at += size;
      size = static_cast<std::uint32_t>(layer.size());
      all.insert(all.end(), layer.begin(), layer.end());
    }
    chunk.bytes = all;
  }
  return messageOf(std::shared_ptr<const EncodedFrame>(plain)).joined();
}

Description streamDescription() {
  Description description;
  description.name = "seed";
  fuse_flow::Camera camera;
  camera.name = "left";
  camera.intrinsics = {640, 480, 525, 525, 319.5f, 239.5f, {}};
  description.cameras = {camera};
  return description;
}

std::string streamFile(const Bytes& frame) {
  const std::string path = scratchFile("seed.ffs", "");
  {
    StreamWriter writer(path, streamDescription());
    writer.write(frame.data(), frame.size());
    writer.describe(streamDescription());
    writer.write(frame.data(), frame.size());
  }
  return fuse_flow::io::readFile(path);
}

}  // namespace

void addStreamSeeds(Seeds& seeds) {
  EncodingOptions options;
  options.threads = 1;
  options.camera_masks = true;
  EncodingOptions coarse = options;
  coarse.chroma_step = 4;
  coarse.layers = 2;
  seeds["stream_frame"] = {asString(encoded(options, true)), asString(encoded(options, false)),
                           asString(encoded(coarse, false))};
  seeds["stream_file"] = {streamFile(encoded(coarse, true))};
  seeds["stream_description"] = {toJson(streamDescription())};
  seeds["stream_client"] = {"{\"type\": \"got\", \"frame\": 17}",
                            "{\"type\": \"want\", \"points\": 1000, \"bytes_per_second\": 100000, \"region\": "
                            "{\"min\": [-1, -1, 0], \"max\": [1, 1, 2.5]}, "
                            "\"viewpoint\": [0, 0, 1e3], \"step\": 0.002}"};
  seeds["foxglove_client"] = {
      "{\"op\": \"subscribe\", \"subscriptions\": [{\"id\": 0, \"channelId\": 3}, {\"id\": 1, \"channelId\": 4}]}",
      "{\"op\": \"unsubscribe\", \"subscriptionIds\": [0, 1]}", "{\"op\": \"advertise\"}", "\1\2\3\4"};
  seeds["stream_link"] = {"wss://viewer.example:8443/stream?token=abcdefgh12345678&x=%20", "http://127.0.0.1:8080/",
                          "ws://[::1]/a%2fb?token=%zz"};
}

}  // namespace fuse_flow_fuzz
