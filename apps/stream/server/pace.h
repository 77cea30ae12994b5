#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

namespace fuse_flow::stream::network {

using Clock = std::chrono::steady_clock;

/** \brief How many bytes of a frame a client gets, so that it gets frames at the rate at which they are made: fewer points rather than fewer
 *  frames.
 *
 *  A frame that is answered tells how long its bytes took. The answer comes a round trip after the last byte has gone through the narrowest
 *  place on the way; bytes before it went through by the round trip before the answer before. So n bytes that were sent at t and answered at
 *  a, after another answer at b, took a − r − max(t, b − r), where r is the round trip: the shortest of the last pings. What the client takes
 *  is the median of n / that of the answers of the last second, so that one hiccup changes nothing; of two the greater.
 *
 *  The next frame gets 85 % of what the client takes in the time from one frame to the next, or all of it if that is less. Down at once,
 *  up by no more than a quarter from frame to frame: what was not sent is not known to arrive. Never below 16 KB, where a picture becomes
 *  useless: from there on it is frames that become fewer. The first frame is of 4 MB at most, as nothing is known yet.
 *
 *  One thread may use it at a time. */
class Pace {
 public:
  static constexpr std::size_t kLeast = 16 << 10, kFirst = 4 << 20;  ///< bytes

  void roundTrip(Clock::duration time);
  /** \param bytes that were sent from `sent` on  \param small no frame, whose bytes tell what the client takes only if they took long */
  void answered(std::size_t bytes, Clock::time_point sent, Clock::time_point now, Clock::duration interval,
                bool small = false);
  /** \brief At most so many bytes for the next frame; 0: any number.
   *  \param interval from frame to frame  \param whole bytes of the whole frame  \param wished bytes per second, at most
   *  \param patient the client has time for it: it grows freely */
  std::size_t budget(Clock::duration interval, std::size_t whole, std::optional<std::uint64_t> wished, bool patient);

  /** \brief Bytes per second; 0: not known. */
  double rate() const;
  Clock::duration shortestRoundTrip() const;
  bool anyAnswer() const { return last_answer_.has_value(); }

 private:
  struct Answer {
    Clock::time_point when;
    double rate;
  };
  std::deque<Clock::duration> round_trips_;
  std::deque<Answer> answers_;
  std::optional<Clock::time_point> last_answer_;
  std::optional<double> limit_;  ///< bytes of the last frame that was limited; absent: it was not
};

}  // namespace fuse_flow::stream::network
