#include "stream/foxglove/feed.h"

#include "stream/foxglove/end_thread.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace fuse_flow::stream::foxglove {

namespace {

constexpr int kMostOfSide = 65500;  // pixels, of a JPEG

}  // namespace

Feed::Feed(std::shared_ptr<network::FrameHub> hub, network::Notices& notices, int threads)
    : hub_(std::move(hub)),
      notices_(notices),
      threads_(threads),
      session_(std::to_string(network::nanosecondsSince1970())),
      images_(notices) {}

Feed::~Feed() { stop(); }

void Feed::stop() {
  images_.stop();
  endThread(mutex_, stopped_, wanted_, thread_);
}

void Feed::describe(const Description& description) {
  const auto now = static_cast<std::uint64_t>(network::nanosecondsSince1970());
  const std::lock_guard<std::mutex> lock(mutex_);
  channels_ = std::make_shared<const Channels>(channelsOf(description, now, *channels_));
  description_ = description;
}

bool Feed::publishImage(std::size_t camera, const ImageView<Rgb8>& pixels, std::uint64_t time,
                        std::shared_ptr<const void> owner) {
  ImageChannel channel;
  bool added = false;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto refuse = [&](const std::string& what) {
      throw std::invalid_argument("stream::Server::publishImage: camera " + std::to_string(camera) + what);
    };
    const std::size_t cameras = channels_->images.size();
    if (camera >= cameras) refuse(": must be below " + std::to_string(cameras) + ", the cameras that are described");
    channel = channels_->images[camera];
    const auto size = [](int width, int height) { return std::to_string(width) + "x" + std::to_string(height); };
    if (pixels.width != channel.width || pixels.height != channel.height)
      refuse(": its image is of " + size(pixels.width, pixels.height) + " pixels, must be of " +
             size(channel.width, channel.height) + ", as its calibration");
    if (std::min(pixels.width, pixels.height) < 1 || std::max(pixels.width, pixels.height) > kMostOfSide)
      refuse(": its image is of " + size(pixels.width, pixels.height) + " pixels, must have sides of 1 to " +
             std::to_string(kMostOfSide));
    if (channel.id == 0) {
      const auto now = static_cast<std::uint64_t>(network::nanosecondsSince1970());
      channels_ = std::make_shared<const Channels>(channelsOf(description_, now, *channels_, camera));
      channel = channels_->images[camera];
      added = true;
    }
  }
  images_.publish(channel.id, {pixels, std::move(owner), time, channel.frame});
  return added;
}

bool Feed::imageWanted(std::size_t camera) const {
  const std::shared_ptr<const Channels> known = channels();
  return camera < known->images.size() && known->images[camera].id != 0 && images_.wanted(known->images[camera].id);
}

std::shared_ptr<const Channels> Feed::channels() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return channels_;
}

void Feed::subscribed() {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++subscribers_;
}

void Feed::unsubscribed() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (--subscribers_ == 0) newest_.reset();
}

std::shared_ptr<const CloudPayload> Feed::request(const std::shared_ptr<const network::PublishedFrame>& frame,
                                                  const std::weak_ptr<network::Channel>& channel) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (newest_ && newest_->sequence >= frame->sequence) return newest_;
  if (stopped_) return nullptr;
  if (!next_ || next_->sequence < frame->sequence) next_ = frame;
  waiting_.push_back(channel);
  if (!thread_.joinable()) thread_ = std::thread([this] { run(); });
  wanted_.notify_one();
  return nullptr;
}

std::shared_ptr<const CloudPayload> Feed::newest() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return newest_;
}

std::uint64_t Feed::failed() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return failed_;
}

std::shared_ptr<const CloudPayload> Feed::made(CloudPayloads& payloads, const network::PublishedFrame& frame) {
  try {
    CloudPayload payload = payloads.make(frame.nearest(0), channels()->frame);
    payload.sequence = frame.sequence;
    return std::make_shared<const CloudPayload>(std::move(payload));
  } catch (const std::exception& error) {  // a frame that was given encoded, and is none; or no memory
    notices_.add("a frame cannot be sent to Foxglove: " + std::string(error.what()));
    return nullptr;
  }
}

void Feed::run() {
  CloudPayloads payloads(threads_);
  for (;;) {
    std::shared_ptr<const network::PublishedFrame> frame;
    std::vector<std::weak_ptr<network::Channel>> waiting;
    {
      std::unique_lock<std::mutex> lock(mutex_);
      wanted_.wait(lock, [&] { return stopped_ || next_; });
      if (stopped_) return;
      frame = std::exchange(next_, nullptr);
      waiting.swap(waiting_);
    }
    std::shared_ptr<const CloudPayload> payload = made(payloads, *frame);
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (!payload)
        failed_ = frame->sequence;
      else if (subscribers_ > 0)
        newest_ = std::move(payload);
    }
    for (const std::weak_ptr<network::Channel>& each : waiting)
      if (const std::shared_ptr<network::Channel> channel = each.lock()) channel->wake();
  }
}

}  // namespace fuse_flow::stream::foxglove
