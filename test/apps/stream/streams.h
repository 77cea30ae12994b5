#pragma once

#include "clouds_to_stream.h"

#include <fuse_flow/stream/client.h>
#include <fuse_flow/stream/server.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

namespace fuse_flow::test {

/** \brief A server at a port that is free, in no hurry to let anybody go. */
inline stream::ServerOptions anyPort() {
  stream::ServerOptions options;
  options.port = 0;
  options.connections_per_second = 10'000;
  options.handshake_time = std::chrono::seconds(30);
  options.answer_time = std::chrono::seconds(60);
  return options;
}

inline stream::ClientOptions patient() {
  stream::ClientOptions options;
  options.threads = 1;
  options.connect_time = std::chrono::seconds(30);
  options.silence = std::chrono::seconds(60);
  return options;
}

/** \brief A part of the wall, of `points` points. */
inline std::shared_ptr<const stream::EncodedFrame> frameOf(std::size_t points, std::uint64_t number) {
  stream::EncodingOptions options;
  options.chunk_points = 1024;
  options.threads = 1;
  stream::FrameEncoder encoder(options);
  auto cloud = wall(static_cast<unsigned int>(number + 1));
  cloud.resize(std::min(points, cloud.size()));
  return encoder.encode(cloud, {number, 5, 7});
}

constexpr auto kLong = std::chrono::milliseconds(30'000);

inline bool anyHas(const std::vector<std::string>& lines, const std::string& text) {
  return std::any_of(lines.begin(), lines.end(),
                     [&](const std::string& line) { return line.find(text) != std::string::npos; });
}

}  // namespace fuse_flow::test
