#include "stream/server/pace.h"

#include <algorithm>
#include <vector>

namespace fuse_flow::stream::network {

namespace {

constexpr std::size_t kRoundTrips = 8, kAnswers = 64;
constexpr double kPart = 0.85, kGrowth = 1.25;
constexpr auto kRecent = std::chrono::seconds(1);
// Less than this is not measured: it is the time that a thread needs to wake up.
constexpr auto kShortest = std::chrono::microseconds(100);

double seconds(Clock::duration time) { return std::chrono::duration<double>(time).count(); }

}  // namespace

void Pace::roundTrip(Clock::duration time) {
  round_trips_.push_back(time);
  if (round_trips_.size() > kRoundTrips) round_trips_.pop_front();
}

Clock::duration Pace::shortestRoundTrip() const {
  return round_trips_.empty() ? Clock::duration::zero() : *std::min_element(round_trips_.begin(), round_trips_.end());
}

void Pace::answered(std::size_t bytes, Clock::time_point sent, Clock::time_point now, Clock::duration interval,
                    bool small) {
  const Clock::duration trip = shortestRoundTrip();
  const Clock::time_point begin = last_answer_ ? std::max(sent, *last_answer_ - trip) : sent;
  const Clock::duration took = std::max<Clock::duration>(now - trip - begin, kShortest);
  last_answer_ = now;
  // A few bytes that came in time tell how long a thread sleeps, not what the client takes.
  if ((small || bytes < kLeast) && took < interval) return;
  answers_.push_back({now, static_cast<double>(bytes) / seconds(took)});
  while (answers_.size() > 1 && (answers_.front().when < now - kRecent || answers_.size() > kAnswers))
    answers_.pop_front();
}

double Pace::rate() const {
  if (answers_.empty()) return 0;
  std::vector<double> rates;
  for (const Answer& answer : answers_) rates.push_back(answer.rate);
  const auto middle = rates.begin() + static_cast<std::ptrdiff_t>(rates.size() / 2);
  std::nth_element(rates.begin(), middle, rates.end());
  return *middle;
}

std::size_t Pace::budget(Clock::duration interval, std::size_t whole, std::optional<std::uint64_t> wished,
                         bool patient) {
  const double time = seconds(interval);
  double most = !answers_.empty() ? kPart * rate() * time : static_cast<double>(kFirst);
  if (limit_ && !patient) most = std::min(most, kGrowth * *limit_);
  if (wished) most = std::min(most, static_cast<double>(*wished) * time);
  most = std::max(most, static_cast<double>(kLeast));
  if (most >= static_cast<double>(whole)) {
    limit_.reset();
    return 0;
  }
  limit_ = most;
  return static_cast<std::size_t>(most);
}

}  // namespace fuse_flow::stream::network
