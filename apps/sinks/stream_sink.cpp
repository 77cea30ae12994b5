#include "sinks/stream_sink.h"

#include <algorithm>
#include <utility>

namespace fuse_flow::io {
namespace {

bool standAlike(const std::vector<Camera>& a, const std::vector<Camera>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Camera& one, const Camera& other) {
    return one.name == other.name && sameCalibration(one, other);
  });
}

bool fits(const ImageView<Rgb8>& image, const Camera& camera) {
  const Intrinsics& intrinsics = camera.color ? camera.color->intrinsics : camera.intrinsics;
  return image.width == intrinsics.width && image.height == intrinsics.height;
}

std::int64_t now() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace

stream::FrameTimes timesOf(const FusedFrame& frame) {
  return {frame.number, 1000 * static_cast<std::int64_t>(frame.arrived.count()), now()};
}

StreamSink::StreamSink(std::shared_ptr<stream::Server> server, stream::Description description, bool images)
    : server_(std::move(server)), description_(std::move(description)), images_(images) {}

void StreamSink::describe(const std::vector<Camera>& cameras) {
  const auto time = std::chrono::steady_clock::now();
  if (described_ && (time - described_at_ < std::chrono::seconds(1) || standAlike(description_.cameras, cameras)))
    return;
  description_.cameras = cameras;
  server_->describe(description_);
  described_ = true;
  described_at_ = time;
}

void StreamSink::publishImages(const std::shared_ptr<const FusedFrame>& frame, const stream::FrameTimes& times) {
  const std::vector<DepthView>& views = frame->input.rig.views;
  for (std::size_t k = 0; k < std::min(views.size(), description_.cameras.size()); ++k) {
    // A camera whose calibration has changed is described within a second.
    if (!views[k].color || !fits(views[k].color, description_.cameras[k])) continue;
    // Rather the camera's images than the frame, whose memory is larger and wanted for the next one.
    std::shared_ptr<const void> owner = frame;
    if (k < frame->live.size() && frame->live[k] && frame->live[k]->color.data.data() == views[k].color.data)
      owner = frame->live[k];
    server_->publishImage(k, views[k].color, times, std::move(owner));
  }
}

void StreamSink::take(const std::shared_ptr<const FusedFrame>& frame) {
  describe(frame->input.rig.cameras);
  const stream::FrameTimes times = frame->encoded ? frame->encoded->times : timesOf(*frame);
  if (images_) publishImages(frame, times);  // first: they are encoded while the cloud is
  if (frame->encoded) {
    server_->publish(frame->encoded);
  } else if (frame->has_normals) {
    server_->publish(frame->with_normals, times);
  } else {
    server_->publish(frame->cloud, times);
  }
}

std::vector<std::string> StreamSink::finish() { return server_->takeNotices(); }

}  // namespace fuse_flow::io
