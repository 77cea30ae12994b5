#include "stream/server/frame_session.h"

#include "stream/server/client_messages.h"

#include <fuse_flow/stream/streamed_cloud.h>

#include <algorithm>
#include <utility>

namespace fuse_flow::stream::network {

namespace {

using std::chrono::milliseconds;

constexpr auto kLookEvery = milliseconds(500);
constexpr auto kPingEvery = std::chrono::seconds(2);
constexpr auto kSoon = milliseconds(100);
constexpr auto kRefineAfter = std::chrono::seconds(1);
constexpr double kSlowest = 100e3;  // bytes per second: whoever takes less is let go

Clock::duration timeFor(std::size_t bytes, double bytes_per_second) {
  return std::chrono::duration_cast<Clock::duration>(
      std::chrono::duration<double>(static_cast<double>(bytes) / bytes_per_second));
}

}  // namespace

FrameSession::FrameSession(const std::shared_ptr<Channel>& channel, std::shared_ptr<FrameHub> hub, Gate& gate,
                           milliseconds answer_time)
    : channel_(*channel), shared_channel_(channel), hub_(std::move(hub)), gate_(gate), answer_time_(answer_time) {}

void FrameSession::opened() {
  heard_ = pinged_ = earliest_ = last_answer_ = Clock::now();
  member_ = hub_->join(shared_channel_, kSubprotocol);
  channel_.ping();  // before the first frame, so that its time is known without that
  woken();
}

void FrameSession::closed() {
  ended_ = true;
  if (!member_) return;
  member_->sending = 0;
  hub_->leave(member_);
}

void FrameSession::refuse(const std::string& reason) {
  if (std::exchange(ended_, true)) return;
  ++gate_.dropped;
  gate_.notices.add("client " + channel_.address() + " was let go: " + reason);
  channel_.close(kPolicy, reason);
}

void FrameSession::received(std::string_view message, bool binary) {
  if (ended_) return;
  heard_ = Clock::now();
  if (binary) return refuse("a message must be text");
  try {
    const ClientMessage parsed = clientMessage(message);
    if (const Got* got = std::get_if<Got>(&parsed))
      answered(got->frame);
    else
      setWishes(std::get<Wishes>(parsed));
  } catch (const FormatError& error) {
    return refuse(error.what());
  }
  look();
}

void FrameSession::answered(std::uint64_t number) {
  const auto frame = std::find_if(unanswered_.begin(), unanswered_.end(),
                                  [&](const Unanswered& sent) { return sent.number == number; });
  if (frame == unanswered_.end()) throw FormatError("got names a frame that was not sent, or was answered before");
  // Messages arrive in order: those before it have, too.
  std::size_t bytes = 0;
  const auto count = static_cast<std::uint64_t>(frame - unanswered_.begin()) + 1;
  const Clock::time_point sent = unanswered_.front().sent;
  for (std::uint64_t k = 0; k < count; ++k) {
    bytes += unanswered_.front().bytes;
    unanswered_.pop_front();
  }
  last_answer_ = heard_;
  pace_.answered(bytes, sent, heard_, hub_->interval());
  const std::lock_guard<std::mutex> lock(member_->mutex);
  member_->report.frames += count;
  member_->report.bytes += bytes;
  member_->report.bytes_per_second = pace_.rate();
}

void FrameSession::setWishes(const Wishes& wishes) {
  wishes_ = wishes;
  member_->step = wishes.step ? hub_->stepFor(*wishes.step) : 0;
  again_ = true;
  earliest_ = std::min(earliest_, Clock::now() + kRefineAfter);  // a slow wish from before does not hold it up
  const std::shared_ptr<const PublishedFrame> frame = hub_->latest();
  if (member_->step > 0 && frame && !frame->from_cloud)
    gate_.notices.add("client " + channel_.address() +
                      " wants a coarser step; frames that were given encoded are sent as they are");
}

void FrameSession::sent() {
  sending_ = false;
  member_->sending = 0;
  look();
}

void FrameSession::pong(std::chrono::steady_clock::duration round_trip) {
  heard_ = Clock::now();
  pace_.roundTrip(round_trip);
  const std::lock_guard<std::mutex> lock(member_->mutex);
  member_->report.round_trip = std::chrono::duration<double>(pace_.shortestRoundTrip()).count();
}

bool FrameSession::overdue(Clock::time_point now) {
  if (unanswered_.empty()) {
    if (now - heard_ <= answer_time_) return false;
    refuse("it does not answer pings");
    return true;
  }
  const Unanswered& oldest = unanswered_.front();
  if (now - std::max(oldest.sent, last_answer_) <= answer_time_ + timeFor(oldest.bytes, kSlowest)) return false;
  refuse("a frame was not answered in time");
  return true;
}

void FrameSession::woken() {
  if (ended_) return;
  const Clock::time_point now = Clock::now();
  if (overdue(now)) return;
  if (now - pinged_ >= std::min<Clock::duration>(kPingEvery, answer_time_ / 3)) {
    pinged_ = now;
    channel_.ping();
  }
  next_look_ = now + std::min<Clock::duration>(kLookEvery, answer_time_ / 4);
  channel_.wakeAt(next_look_);
  look();
}

bool FrameSession::canRefine(const PublishedFrame& frame, Clock::time_point now) const {
  return limited_ && unanswered_.empty() && now - frame.when >= kRefineAfter;
}

void FrameSession::look() {
  if (ended_ || sending_) return;
  if (const auto [json, count] = hub_->description(); count != described_) {
    described_ = count;
    sending_ = true;
    return channel_.send({false, {{json->data(), json->size()}}, json});
  }
  // Until the first one is answered nothing is known of the client, and a second would double a mistake.
  if (unanswered_.size() > (pace_.anyAnswer() ? 1 : 0)) return;
  const std::shared_ptr<const PublishedFrame> frame = hub_->latest();
  if (!frame) return;
  const Clock::time_point now = Clock::now();
  const bool newer = frame->sequence != sequence_;
  if (!newer && !again_ && !canRefine(*frame, now)) return;
  Clock::time_point earliest = earliest_;
  // Wishes that change come with the next frame, unless none comes, as from a picture that stands.
  if (!newer && again_)
    earliest = std::max(earliest, frame->when + std::min<Clock::duration>(2 * hub_->interval(), kSoon));
  if (now < earliest) return channel_.wakeAt(std::min(earliest, next_look_));
  sendFrame(*frame, now, !newer && !again_);
}

void FrameSession::sendFrame(const PublishedFrame& published, Clock::time_point now, bool refines) {
  std::shared_ptr<const EncodedFrame> frame = published.nearest(member_->step);
  if (!frame) return;
  const Clock::duration interval =
      refines ? std::min<Clock::duration>(now - published.when, std::chrono::seconds(10)) : hub_->interval();
  const std::size_t budget = pace_.budget(interval, frame->bytes(), wishes_.bytes_per_second, refines);
  const Selection selection = select(*frame, wishes_, budget);
  // Not for a handful of points.
  if (refines && selection.bytes < (budget > 0 ? bytes_ + bytes_ / 4 : bytes_ + 1)) {
    limited_ = budget > 0;
    return;
  }
  // Whether there would be more, did its wishes alone choose.
  limited_ = budget > 0 && select(*frame, wishes_, 0).bytes > selection.bytes;
  if (sequence_ != 0 && published.sequence > sequence_ + 1) {
    const std::lock_guard<std::mutex> lock(member_->mutex);
    member_->report.replaced += published.sequence - sequence_ - 1;
  }
  sequence_ = published.sequence;
  again_ = false;
  const auto message = std::make_shared<const Message>(messageOf(std::move(frame), selection));
  Outgoing outgoing{true, {}, message};
  for (const Message::Piece& piece : message->pieces) outgoing.pieces.push_back({piece.data, piece.size});
  bytes_ = message->size();
  unanswered_.push_back({message->frame->times.number, bytes_, now});
  if (wishes_.bytes_per_second) earliest_ = now + timeFor(bytes_, static_cast<double>(*wishes_.bytes_per_second));
  {
    const std::lock_guard<std::mutex> lock(member_->mutex);
    member_->report.points = selection.points;
    member_->report.points_of_frame = message->frame->points;
  }
  member_->sending_bytes = message->frame->bytes();
  member_->sending = published.sequence;
  sending_ = true;
  channel_.send(std::move(outgoing));
}

}  // namespace fuse_flow::stream::network
