#include "stream/foxglove/image_feed.h"

#include "recordings/images/jpeg_bytes.h"
#include "stream/foxglove/end_thread.h"
#include "stream/foxglove/protobuf_writer.h"

#include <algorithm>
#include <cstring>
#include <exception>
#include <utility>
#include <vector>

namespace fuse_flow::stream::foxglove {

namespace {

// Where differences are hardly seen; half the bytes of 95.
constexpr int kJpegQuality = 85;

void wakeAll(const std::vector<std::weak_ptr<network::Channel>>& clients) {
  for (const std::weak_ptr<network::Channel>& each : clients)
    if (const std::shared_ptr<network::Channel> client = each.lock()) client->wake();
}

RawImage copyOf(const RawImage& image) {
  RawImage copy = image;
  const auto width = static_cast<std::size_t>(image.pixels.width);
  auto pixels = std::make_shared<std::vector<Rgb8>>(width * static_cast<std::size_t>(image.pixels.height));
  for (int v = 0; v < image.pixels.height; ++v)
    std::copy_n(image.pixels.row(v), width, pixels->data() + width * static_cast<std::size_t>(v));
  copy.pixels = ImageView<Rgb8>(pixels->data(), image.pixels.width, image.pixels.height);
  copy.owner = std::move(pixels);
  return copy;
}

}  // namespace

void ImageFeed::stop() { endThread(mutex_, stopped_, wanted_, thread_); }

void ImageFeed::subscribe(std::uint32_t channel, const std::weak_ptr<network::Channel>& client) {
  const std::lock_guard<std::mutex> lock(mutex_);
  slots_[channel].subscribers.insert(client);
}

void ImageFeed::unsubscribe(std::uint32_t channel, const std::weak_ptr<network::Channel>& client) {
  decltype(slots_)::node_type
      gone;  // released after the lock: its image is the caller's, whose deleter may ask the server
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto slot = slots_.find(channel);
  if (slot == slots_.end()) return;
  slot->second.subscribers.erase(client);
  if (slot->second.subscribers.empty()) gone = slots_.extract(slot);
}

bool ImageFeed::wanted(std::uint32_t channel) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return slots_.count(channel) > 0;
}

void ImageFeed::publish(std::uint32_t channel, RawImage image) {
  if (!wanted(channel)) return;
  if (!image.owner) image = copyOf(image);
  auto raw = std::make_shared<const RawImage>(std::move(image));
  std::vector<std::weak_ptr<network::Channel>> clients;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto slot = slots_.find(channel);
    if (stopped_ || slot == slots_.end()) return;
    slot->second.raw.swap(raw);  // the one before goes after the lock: it may be large
    slot->second.raw_sequence = ++sequence_;
    clients.assign(slot->second.subscribers.begin(), slot->second.subscribers.end());
  }
  wakeAll(clients);
}

std::shared_ptr<const ImagePayload> ImageFeed::request(std::uint32_t channel, std::uint64_t after,
                                                       std::uint64_t& waits_for) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found = slots_.find(channel);
  if (stopped_ || found == slots_.end()) return nullptr;
  Slot& slot = found->second;
  const bool waited = waits_for != 0 && slot.made && slot.made->sequence >= waits_for;
  if (slot.made && slot.made->sequence > after && (waited || (!slot.raw && slot.making == 0))) {
    waits_for = 0;
    return slot.made;
  }
  if (slot.making > after) {
    if (waits_for == 0) waits_for = slot.making;
  } else if (slot.raw) {
    if (waits_for == 0) waits_for = slot.raw_sequence;
    slot.requested = true;
    if (!thread_.joinable()) thread_ = std::thread([this] { run(); });
    wanted_.notify_one();
  } else {
    waits_for = 0;  // it could not be encoded
  }
  return nullptr;
}

std::map<std::uint32_t, ImageFeed::Slot>::iterator ImageFeed::next() {
  const auto waits = [](const auto& each) { return each.second.raw && each.second.requested; };
  const auto found = std::find_if(slots_.upper_bound(last_), slots_.end(), waits);
  return found != slots_.end() ? found : std::find_if(slots_.begin(), slots_.end(), waits);
}

std::shared_ptr<const ImagePayload> ImageFeed::made(const RawImage& image, std::uint64_t sequence) {
  try {
    const std::string jpeg = io::jpegBytes(image.pixels, kJpegQuality, true);
    ++encoded_;
    return std::make_shared<const ImagePayload>(
        ImagePayload{sequence, image.time,
                     ProtobufWriter().time(1, image.time).text(2, jpeg).text(3, "jpeg").text(4, image.frame).bytes()});
  } catch (const std::exception& error) {  // no memory
    notices_.add("an image cannot be sent to Foxglove: " + std::string(error.what()));
    return nullptr;
  }
}

void ImageFeed::run() {
  std::unique_lock<std::mutex> lock(mutex_);
  for (;;) {
    auto slot = slots_.end();
    wanted_.wait(lock, [&] { return stopped_ || (slot = next()) != slots_.end(); });
    if (stopped_) return;
    const std::uint32_t channel = last_ = slot->first;
    const std::uint64_t sequence = slot->second.making = slot->second.raw_sequence;
    std::shared_ptr<const RawImage> raw = std::exchange(slot->second.raw, nullptr);
    slot->second.requested = false;
    lock.unlock();
    std::shared_ptr<const ImagePayload> payload = made(*raw, sequence);
    raw.reset();
    lock.lock();
    slot = slots_.find(channel);
    // All have gone, or all have gone and others have come.
    if (slot == slots_.end() || slot->second.making != sequence) continue;
    slot->second.making = 0;
    if (payload) slot->second.made = std::move(payload);
    const std::vector<std::weak_ptr<network::Channel>> clients(slot->second.subscribers.begin(),
                                                               slot->second.subscribers.end());
    lock.unlock();
    wakeAll(clients);
    lock.lock();
  }
}

}  // namespace fuse_flow::stream::foxglove
