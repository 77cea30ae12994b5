#include "stream/server/frame_hub.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <utility>

namespace fuse_flow::stream::network {

std::shared_ptr<const EncodedFrame> PublishedFrame::nearest(std::size_t step) const {
  for (std::size_t k = step; k < kSteps; ++k)
    if (of_step[k]) return of_step[k];
  for (std::size_t k = step; k-- > 0;)
    if (of_step[k]) return of_step[k];
  return nullptr;
}

std::shared_ptr<Member> FrameHub::join(std::weak_ptr<Channel> channel, std::string subprotocol, bool watching) {
  auto member = std::make_shared<Member>(std::move(channel));
  member->watching = watching;
  member->report.subprotocol = std::move(subprotocol);
  if (const std::shared_ptr<Channel> to = member->channel.lock()) member->report.address = to->address();
  const std::lock_guard<std::mutex> lock(mutex_);
  members_.push_back(member);
  return member;
}

void FrameHub::leave(const std::shared_ptr<Member>& member) {
  const std::lock_guard<std::mutex> lock(mutex_);
  members_.remove(member);
}

void FrameHub::publish(PublishedFrame frame) {
  std::vector<std::shared_ptr<Member>> members;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    frame.sequence = ++published_;
    frame.when = Clock::now();
    if (latest_) {
      const Clock::duration gap = std::clamp<Clock::duration>(frame.when - latest_->when, std::chrono::milliseconds(5),
                                                              std::chrono::seconds(1));
      interval_ = published_ == 2 ? gap : (7 * interval_ + gap) / 8;
    }
    latest_ = std::make_shared<const PublishedFrame>(std::move(frame));
    members.assign(members_.begin(), members_.end());
  }
  wakeAll(members);
}

void FrameHub::describe(std::string json) {
  std::vector<std::shared_ptr<Member>> members;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    description_ = std::make_shared<const std::string>(std::move(json));
    ++descriptions_;
    members.assign(members_.begin(), members_.end());
  }
  wakeAll(members);
}

void FrameHub::goAway() {
  for (const std::shared_ptr<Member>& member : copyOfMembers())
    if (const std::shared_ptr<Channel> channel = member->channel.lock()) channel->goAway();
}

void FrameHub::wakeAll(const std::vector<std::shared_ptr<Member>>& members) {
  for (const std::shared_ptr<Member>& member : members)
    if (const std::shared_ptr<Channel> channel = member->channel.lock()) channel->wake();
}

std::shared_ptr<const PublishedFrame> FrameHub::latest() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return latest_;
}

std::pair<std::shared_ptr<const std::string>, std::uint64_t> FrameHub::description() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return {description_, descriptions_};
}

Clock::duration FrameHub::interval() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return interval_;
}

std::uint64_t FrameHub::published() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return published_;
}

std::size_t FrameHub::stepFor(double wished) const {
  // Not coarser than was asked for; a step that is one of ours but for rounding is that one.
  std::size_t step = 0;
  while (step + 1 < kSteps && step_ * std::ldexp(1.0, static_cast<int>(step) + 1) <= wished * (1 + 1e-9)) ++step;
  return step;
}

std::vector<std::shared_ptr<Member>> FrameHub::copyOfMembers() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return {members_.begin(), members_.end()};
}

std::size_t FrameHub::members() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return members_.size();
}

std::size_t FrameHub::watchers() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return static_cast<std::size_t>(
      std::count_if(members_.begin(), members_.end(), [](const auto& member) { return member->watching.load(); }));
}

std::array<std::size_t, kSteps> FrameHub::wanted() const {
  std::array<std::size_t, kSteps> wanted{};
  for (const std::shared_ptr<Member>& member : copyOfMembers())
    if (member->watching) ++wanted[member->step];
  return wanted;
}

std::vector<ClientReport> FrameHub::reports() const {
  std::vector<ClientReport> reports;
  const Clock::time_point now = Clock::now();
  for (const std::shared_ptr<Member>& member : copyOfMembers()) {
    const std::lock_guard<std::mutex> lock(member->mutex);
    reports.push_back(member->report);
    reports.back().seconds = std::chrono::duration<double>(now - member->since).count();
  }
  return reports;
}

std::size_t FrameHub::shed() {
  const std::vector<std::shared_ptr<Member>> members = copyOfMembers();
  const std::uint64_t newest = published();
  // Of each frame and image that is held, its bytes once, however many hold it. In different steps it is different bytes; the most of them
  // will do.
  using What = std::pair<std::uint64_t, std::uint64_t>;
  const auto held_by = [&](const Member& member) -> std::optional<What> {
    const What what{member.sending, member.sending_image};
    if (what.first == 0 || what == What{newest, 0}) return std::nullopt;
    return what;
  };
  std::map<What, std::size_t, std::greater<>> held;
  for (const std::shared_ptr<Member>& member : members) {
    const std::optional<What> what = held_by(*member);
    if (!what) continue;
    std::size_t& bytes = held[*what];
    bytes = std::max(bytes, member->sending_bytes.load());
  }
  std::size_t sum = 0;
  What up_to{0, 0};  // this one and those before are too much
  for (const auto& [what, bytes] : held) {
    sum += bytes;
    if (sum <= held_bytes_) continue;
    up_to = what;
    break;
  }
  std::size_t ended = 0;
  for (const std::shared_ptr<Member>& member : members) {
    const std::optional<What> what = held_by(*member);
    if (!what || *what > up_to) continue;
    if (const std::shared_ptr<Channel> channel = member->channel.lock()) {
      channel->drop();
      ++ended;
    }
  }
  return ended;
}

}  // namespace fuse_flow::stream::network
