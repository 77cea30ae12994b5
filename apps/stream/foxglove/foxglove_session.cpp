#include "stream/foxglove/foxglove_session.h"

#include <fuse_flow/stream/streamed_cloud.h>

#include <algorithm>
#include <optional>
#include <utility>

namespace fuse_flow::stream::foxglove {

using network::Outgoing;
using network::PublishedFrame;
using std::chrono::milliseconds;

namespace {

constexpr auto kLookForOverdue = milliseconds(500);
constexpr auto kPingWhenIdle = std::chrono::seconds(2);
constexpr auto kMoreAfter = std::chrono::seconds(1);
constexpr auto kMostPatience = std::chrono::seconds(10);
constexpr double kSlowestClient = 100e3;   // bytes per second: whoever takes less is let go
constexpr std::size_t kMostStatuses = 16;  // that wait; more are left out
constexpr int kWarning = 1, kError = 2;

/** \brief What is in front of a message of a channel: operation, subscription, time. */
std::string dataHeader(std::uint32_t subscription, std::uint64_t time) {
  std::string header(1, '\1');
  for (int shift = 0; shift < 32; shift += 8) header += static_cast<char>(subscription >> shift & 0xff);
  for (int shift = 0; shift < 64; shift += 8) header += static_cast<char>(time >> shift & 0xff);
  return header;
}

/** \brief A message that begins with what is this client's, and goes on with what is everybody's. */
Outgoing dataMessage(std::string beginning, std::shared_ptr<const void> shared, const void* data, std::size_t size) {
  struct Held {
    std::string beginning;
    std::shared_ptr<const void> shared;
  };
  const auto held = std::make_shared<const Held>(Held{std::move(beginning), std::move(shared)});
  Outgoing outgoing{true, {{held->beginning.data(), held->beginning.size()}}, held};
  if (size > 0) outgoing.pieces.push_back({data, size});
  return outgoing;
}

network::Clock::duration takes(std::size_t bytes) {
  return std::chrono::duration_cast<network::Clock::duration>(
      std::chrono::duration<double>(static_cast<double>(bytes) / kSlowestClient));
}

}  // namespace

FoxgloveSession::FoxgloveSession(const std::shared_ptr<network::Channel>& channel,
                                 std::shared_ptr<network::FrameHub> hub, std::shared_ptr<Feed> feed,
                                 network::Gate& gate, milliseconds answer_time, std::string subprotocol)
    : channel_(*channel),
      shared_channel_(channel),
      hub_(std::move(hub)),
      feed_(std::move(feed)),
      gate_(gate),
      answer_time_(answer_time),
      subprotocol_(std::move(subprotocol)) {}

void FoxgloveSession::opened() {
  heard_ = last_answer_ = Clock::now();
  member_ = hub_->join(shared_channel_, subprotocol_, false);
  ping();  // before the first frame, so that its time is known without that
  woken();
}

void FoxgloveSession::closed() {
  ended_ = true;
  if (!member_) return;
  member_->sending = 0;
  if (member_->watching) feed_->unsubscribed();
  for (const auto& [id, subscription] : of_channels_)
    if (subscription.images) feed_->images().unsubscribe(id, shared_channel_);
  hub_->leave(member_);
}

void FoxgloveSession::refuse(const std::string& reason) {
  if (std::exchange(ended_, true)) return;
  ++gate_.dropped;
  gate_.notices.add("client " + channel_.address() + " was let go: " + reason);
  channel_.close(network::kPolicy, reason);
}

void FoxgloveSession::received(std::string_view message, bool binary) {
  if (ended_) return;
  heard_ = Clock::now();
  try {
    const ClientRequest request = clientRequest(message, binary);
    if (const auto* wanted = std::get_if<Subscribe>(&request)) {
      subscribe(*wanted);
    } else if (const auto* unwanted = std::get_if<Unsubscribe>(&request)) {
      unsubscribe(*unwanted);
    } else {
      say(kError, "this server only sends: it does not know '" + std::get<Unsupported>(request).operation + "'");
    }
  } catch (const FormatError& error) {
    return refuse(error.what());
  }
  look();
}

void FoxgloveSession::subscribe(const Subscribe& request) {
  for (const Subscribe::Entry& entry : request.entries) {
    // Neither is a reason to close: the channel may have gone while the message was on its way.
    if (!channels_ || !channels_->find(entry.channel)) {
      say(kWarning, "there is no channel " + std::to_string(entry.channel));
    } else if (channel_of_.count(entry.id) > 0) {
      say(kWarning, "there is a subscription " + std::to_string(entry.id) + " already");
    } else if (of_channels_.count(entry.channel) > 0) {
      say(kWarning, "there is a subscription to channel " + std::to_string(entry.channel) + " already");
    } else {
      Subscription& subscription = of_channels_[entry.channel];
      subscription.id = entry.id;
      subscription.images = channels_->hasImages(entry.channel);
      if (subscription.images) feed_->images().subscribe(entry.channel, shared_channel_);
      channel_of_[entry.id] = entry.channel;
      if (entry.channel != kPointsChannel) continue;
      sequence_ = requested_ = 0;
      member_->watching = true;
      feed_->subscribed();
    }
  }
}

void FoxgloveSession::unsubscribe(const Unsubscribe& request) {
  for (const std::uint32_t id : request.ids) {
    const auto found = channel_of_.find(id);
    if (found == channel_of_.end())
      say(kWarning, "there is no subscription " + std::to_string(id));
    else
      leave(found->second);
  }
}

void FoxgloveSession::leave(std::uint32_t channel) {
  const auto found = of_channels_.find(channel);
  if (found == of_channels_.end()) return;
  channel_of_.erase(found->second.id);
  if (found->second.images) feed_->images().unsubscribe(channel, shared_channel_);
  of_channels_.erase(found);
  if (channel != kPointsChannel) return;
  member_->watching = false;
  feed_->unsubscribed();
}

void FoxgloveSession::say(int level, const std::string& text) {
  if (statuses_.size() < kMostStatuses) statuses_.push_back(statusMessage(level, text));
}

void FoxgloveSession::ping() {
  // Behind a frame that is being sent it would tell nothing of those before.
  if (pinging_ || sending_) return;
  pinging_ = true;
  pinged_ = Clock::now();
  pinged_for_ = handed_over_;
  channel_.ping();
}

void FoxgloveSession::sent() {
  sending_ = false;
  member_->sending = 0;
  if (std::exchange(sending_counted_, false)) {
    ++handed_over_;
    ping();
  }
  look();
}

void FoxgloveSession::pong(std::chrono::steady_clock::duration round_trip) {
  heard_ = Clock::now();
  pinging_ = false;
  if (pinged_for_ == 0) {
    pace_.roundTrip(round_trip);
    const std::lock_guard<std::mutex> lock(member_->mutex);
    member_->report.round_trip = std::chrono::duration<double>(pace_.shortestRoundTrip()).count();
  } else {
    std::size_t bytes = 0, clouds = 0;
    const Clock::time_point sent = unanswered_.front().sent;
    for (std::size_t k = 0; k < pinged_for_; ++k) {
      bytes += unanswered_.front().bytes;
      if (unanswered_.front().channel == kPointsChannel) ++clouds;
      unanswered_.pop_front();
    }
    handed_over_ -= pinged_for_;
    last_answer_ = heard_;
    pace_.answered(bytes, sent, heard_, hub_->interval(), clouds == 0);
    const std::lock_guard<std::mutex> lock(member_->mutex);
    member_->report.frames += clouds;
    member_->report.images += pinged_for_ - clouds;
    member_->report.bytes += bytes;
    member_->report.bytes_per_second = pace_.rate();
  }
  if (handed_over_ > 0) ping();
  look();
}

bool FoxgloveSession::overdue(Clock::time_point now) {
  if (unanswered_.empty()) {
    if (now - heard_ <= answer_time_) return false;
    refuse("it does not answer pings");
    return true;
  }
  // The pong that is awaited comes after all that its ping was sent for.
  std::size_t bytes = 0;
  for (std::size_t k = 0; k < std::min(std::max<std::size_t>(pinged_for_, 1), unanswered_.size()); ++k)
    bytes += unanswered_[k].bytes;
  if (now - std::max(unanswered_.front().sent, last_answer_) <= answer_time_ + takes(bytes)) return false;
  refuse("a frame was not taken in time");
  return true;
}

void FoxgloveSession::woken() {
  if (ended_) return;
  const Clock::time_point now = Clock::now();
  if (overdue(now)) return;
  if (now - pinged_ >= std::min<Clock::duration>(kPingWhenIdle, answer_time_ / 3)) ping();
  channel_.wakeAt(now + std::min<Clock::duration>(kLookForOverdue, answer_time_ / 4));
  look();
}

void FoxgloveSession::look() {
  if (ended_ || sending_ || sendChannels()) return;
  if (!statuses_.empty()) {
    std::string status = std::move(statuses_.front());
    statuses_.pop_front();
    return send(std::move(status));
  }
  if (!sendMessage()) sendNext();
}

void FoxgloveSession::send(std::string text) {
  sending_ = true;
  channel_.send(Outgoing::text(std::move(text)));
}

bool FoxgloveSession::sendChannels() {
  if (!being_told_) {
    std::shared_ptr<const Channels> now = feed_->channels();
    if (channels_ && channels_->version == now->version) return false;
    being_told_ = std::move(now);
    if (!channels_) {
      channels_ = std::make_shared<const Channels>();
      send(serverInfo(*being_told_, feed_->session()));
      return true;
    }
    std::vector<std::uint32_t> gone;
    for (const Topic& topic : channels_->topics)
      if (!being_told_->find(topic.id)) gone.push_back(topic.id);
    for (const std::uint32_t id : gone) leave(id);
    if (!gone.empty()) {
      send(unadvertisement(gone));
      return true;
    }
  }
  std::vector<const Topic*> added;
  for (const Topic& topic : being_told_->topics)
    if (!channels_->find(topic.id)) added.push_back(&topic);
  channels_ = std::exchange(being_told_, nullptr);
  if (!added.empty()) send(advertisement(added));
  return !added.empty();
}

bool FoxgloveSession::sendMessage() {
  for (auto& [id, subscription] : of_channels_) {
    const Topic* topic = channels_->find(id);
    if (!topic || !topic->message || topic->version == subscription.version) continue;
    subscription.version = topic->version;
    sending_ = true;
    channel_.send(dataMessage(dataHeader(subscription.id, topic->time), topic->message, topic->message->data(),
                              topic->message->size()));
    return true;
  }
  return false;
}

void FoxgloveSession::sendNext() {
  const auto serve = [&](std::map<std::uint32_t, Subscription>::iterator begin,
                         std::map<std::uint32_t, Subscription>::iterator end) {
    for (auto each = begin; each != end; ++each) {
      if (each->first == kPointsChannel)
        sendNextCloud();
      else if (each->second.images)
        sendNextImage(each->first, each->second);
      if (!sending_) continue;
      last_served_ = each->first;
      return true;
    }
    return false;
  };
  const auto after = of_channels_.upper_bound(last_served_);
  if (!serve(after, of_channels_.end())) serve(of_channels_.begin(), after);
}

std::size_t FoxgloveSession::unanswered(std::uint32_t channel) const {
  return static_cast<std::size_t>(std::count_if(unanswered_.begin(), unanswered_.end(),
                                                [&](const Unanswered& each) { return each.channel == channel; }));
}

bool FoxgloveSession::mayFollow(std::uint32_t channel) const {
  return unanswered(channel) <= (pace_.anyAnswer() ? 1 : 0);
}

void FoxgloveSession::beginCounted(std::uint32_t channel, std::size_t bytes, std::uint64_t sequence, std::size_t held,
                                   std::uint64_t image) {
  unanswered_.push_back({channel, bytes, Clock::now()});
  member_->sending_bytes = held;
  member_->sending_image = image;
  member_->sending = sequence;
  sending_ = sending_counted_ = true;
}

void FoxgloveSession::sendNextImage(std::uint32_t channel, Subscription& subscription) {
  if (!mayFollow(channel)) return;
  const std::shared_ptr<const ImagePayload> image =
      feed_->images().request(channel, subscription.sequence, subscription.waits_for);
  if (!image) return;  // it is woken when one is there
  subscription.sequence = image->sequence;
  image_bytes_ += image->message.size();
  beginCounted(channel, image->message.size(), std::max<std::uint64_t>(hub_->published(), 1), image->message.size(),
               image->sequence);
  channel_.send(
      dataMessage(dataHeader(subscription.id, image->time), image, image->message.data(), image->message.size()));
}

void FoxgloveSession::sendNextCloud() {
  if (!member_->watching || !mayFollow(kPointsChannel)) return;
  const std::shared_ptr<const PublishedFrame> frame = hub_->latest();
  if (!frame) return;
  const Clock::time_point now = Clock::now();
  std::shared_ptr<const CloudPayload> payload;
  if (requested_ != 0) {
    payload = feed_->newest();
  } else {
    // The frame again, with more points: no other has come for a while, and the client has time.
    const bool refines = limited_ && unanswered(kPointsChannel) == 0 && now - frame->when >= kMoreAfter;
    if (frame->sequence == sequence_ && !refines) return;
    requested_ = frame->sequence;
    payload = feed_->request(frame, shared_channel_);
  }
  if (!payload || payload->sequence < requested_) {
    if (feed_->failed() < requested_) return;  // it is woken when the frame is there
    sequence_ = std::exchange(requested_, 0);
    return;
  }
  requested_ = 0;
  const bool refines = payload->sequence == sequence_;
  sendCloud(payload, refines ? std::min<Clock::duration>(now - frame->when, kMostPatience) : hub_->interval(), refines);
}

void FoxgloveSession::sendCloud(const std::shared_ptr<const CloudPayload>& payload, Clock::duration time,
                                bool refines) {
  const std::size_t all = payload->up_to.size();
  // In the time of a frame as many bytes go to images as went in as long since the last cloud, which may be much longer ago.
  const Clock::time_point now = Clock::now();
  const double part =
      std::min(1.0, std::chrono::duration<double>(time) / std::chrono::duration<double>(now - cloud_sent_));
  const auto images = static_cast<std::size_t>(part * static_cast<double>(image_bytes_));
  std::size_t budget = pace_.budget(time, payload->bytes(all) + images, std::nullopt, refines);
  if (budget > 0) budget = std::max(budget, images + network::Pace::kLeast) - images;
  std::size_t layers = all;
  while (budget > 0 && layers > 1 && payload->bytes(layers) > budget) --layers;
  limited_ = layers < all;
  if (refines && layers <= layers_) return;
  if (sequence_ != 0 && payload->sequence > sequence_ + 1) {
    const std::lock_guard<std::mutex> lock(member_->mutex);
    member_->report.replaced += payload->sequence - sequence_ - 1;
  }
  sequence_ = payload->sequence;
  layers_ = layers;
  image_bytes_ = 0;
  cloud_sent_ = now;
  Outgoing outgoing =
      dataMessage(dataHeader(of_channels_[kPointsChannel].id, payload->time) + payload->beginning(layers), payload,
                  payload->points.data(), payload->stride * payload->up_to[layers - 1]);
  {
    const std::lock_guard<std::mutex> lock(member_->mutex);
    member_->report.points = payload->up_to[layers - 1];
    member_->report.points_of_frame = payload->up_to.back();
  }
  beginCounted(kPointsChannel, payload->bytes(layers), payload->sequence, payload->points.size(), 0);
  channel_.send(std::move(outgoing));
}

}  // namespace fuse_flow::stream::foxglove
