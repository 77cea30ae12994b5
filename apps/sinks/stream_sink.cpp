#include "sinks/stream_sink.h"

#include <algorithm>
#include <utility>

namespace fuse_flow::io {
namespace {

bool standAlike(const std::vector<Camera>& a, const std::vector<Camera>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Camera& one, const Camera& other) {
    return one.name == other.name && one.T_world_camera.matrix() == other.T_world_camera.matrix();
  });
}

std::int64_t now() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace

stream::FrameTimes timesOf(const FusedFrame& frame) {
  return {frame.number, 1000 * static_cast<std::int64_t>(frame.arrived.count()), now()};
}

StreamSink::StreamSink(std::shared_ptr<stream::Server> server, stream::Description description)
    : server_(std::move(server)), description_(std::move(description)) {}

void StreamSink::describe(const std::vector<Camera>& cameras) {
  const auto time = std::chrono::steady_clock::now();
  if (described_ && (time - described_at_ < std::chrono::seconds(1) || standAlike(description_.cameras, cameras)))
    return;
  description_.cameras = cameras;
  server_->describe(description_);
  described_ = true;
  described_at_ = time;
}

void StreamSink::take(const std::shared_ptr<const FusedFrame>& frame) {
  describe(frame->input.rig.cameras);
  if (frame->encoded) {
    server_->publish(frame->encoded);
  } else if (frame->has_normals) {
    server_->publish(frame->with_normals, timesOf(*frame));
  } else {
    server_->publish(frame->cloud, timesOf(*frame));
  }
}

std::vector<std::string> StreamSink::finish() { return server_->takeNotices(); }

}  // namespace fuse_flow::io
