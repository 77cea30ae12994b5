#pragma once

#include <fuse_flow/impl/camera.hpp>
#include <fuse_flow/impl/live/fullest_set.hpp>
#include <fuse_flow/live/view_synchronizer.h>

#include <algorithm>
#include <utility>

namespace fuse_flow {
namespace detail {

/** \brief Beyond a year nobody waits, and sums of larger numbers overflow. */
inline std::chrono::microseconds upToAYear(std::chrono::microseconds duration) {
  return std::min(duration, std::chrono::microseconds(std::chrono::hours(8766)));
}

}  // namespace detail

inline void checkParameters(const SynchronizerParameters& p) {
  const auto check_positive = [](const char* name, std::chrono::microseconds value) {
    if (value.count() <= 0)
      detail::throwBadArgument("fuse_flow::ViewSynchronizer: ", name, " is ", value.count(), " us, must be positive");
  };
  check_positive("tolerance", p.tolerance);
  check_positive("max_wait", p.max_wait);
  check_positive("offset_window", p.offset_window);
  if (p.capacity == 0) detail::throwBadArgument("fuse_flow::ViewSynchronizer: capacity is 0, must be positive");
}

template <typename PayloadT>
ViewSynchronizer<PayloadT>::ViewSynchronizer(std::size_t cameras, const SynchronizerParameters& parameters, Clock clock)
    : parameters_(parameters), clock_(std::move(clock)) {
  checkParameters(parameters_);
  if (cameras == 0) detail::throwBadArgument("fuse_flow::ViewSynchronizer: cameras is 0, must be positive");
  for (std::chrono::microseconds* duration :
       {&parameters_.tolerance, &parameters_.max_wait, &parameters_.offset_window})
    *duration = detail::upToAYear(*duration);
  for (std::size_t c = 0; c < cameras; ++c) streams_.emplace_back(parameters_.offset_window);
}

template <typename PayloadT>
std::chrono::microseconds ViewSynchronizer<PayloadT>::steadyTime() {
  return std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::steady_clock::now().time_since_epoch());
}

template <typename PayloadT>
void ViewSynchronizer<PayloadT>::push(std::size_t camera, std::uint64_t stamp, PayloadT payload) {
  push(camera, stamp, std::move(payload), clock_());
}

template <typename PayloadT>
void ViewSynchronizer<PayloadT>::push(std::size_t camera, std::uint64_t stamp, PayloadT payload,
                                      std::chrono::microseconds arrival) {
  if (camera >= streams_.size())
    detail::throwBadArgument("fuse_flow::ViewSynchronizer: camera is ", camera, ", must be below ", streams_.size());
  arrival = std::min(arrival, clock_());
  const auto time = static_cast<std::int64_t>(stamp);
  std::deque<Waiting> dropped;  // destroyed after the lock is given up: to free images takes time
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    Stream& stream = streams_[camera];
    if (!accept(stream, time, arrival.count(), dropped)) return;
    while (stream.views.size() >= parameters_.capacity) dropOldest(stream, stream.counts.overrun, dropped);
    stream.views.push_back({time, arrival.count(), std::move(payload)});
  }
  pushed_.notify_one();
}

/** \brief Keeps the camera's books, and the places of frames that it lost; false if the view is of no use. */
template <typename PayloadT>
bool ViewSynchronizer<PayloadT>::accept(Stream& stream, std::int64_t stamp, std::int64_t arrival,
                                        std::deque<Waiting>& dropped) {
  ++stream.counts.received;
  if (stream.newest && stamp == *stream.newest) {
    ++stream.counts.repeated;
    return false;
  }
  stream.counts.waited_for = true;
  if (stream.newest && detail::wrappingDifference(stamp, *stream.newest) < 0) {
    if (static_cast<std::uint64_t>(detail::wrappingDifference(*stream.newest, stamp)) <=
        static_cast<std::uint64_t>(parameters_.max_wait.count())) {
      ++stream.counts.late;
      return false;
    }
    restart(stream, stamp, dropped);
  }
  const std::int64_t gap = stream.newest ? detail::wrappingDifference(stamp, *stream.newest) : 0;
  const std::int64_t lost = stream.newest ? stream.period.lostIn(gap) : 0;
  stream.newest = stamp;
  stream.offset.add(arrival, stamp);
  if (past_ && detail::wrappingDifference(timeOf(stream, stamp), *past_) <= 0) {
    ++stream.counts.late;
    return false;
  }
  if (gap <= parameters_.max_wait.count()) addPlaces(stream, gap, lost, arrival);  // else the others are long gone
  return true;
}

/** \brief Its clock has jumped back, to a stamp. */
template <typename PayloadT>
void ViewSynchronizer<PayloadT>::restart(Stream& stream, std::int64_t stamp, std::deque<Waiting>& dropped) {
  ++stream.counts.restarts;
  while (!stream.views.empty()) dropOldest(stream, stream.counts.unmatched, dropped);
  stream.offset.forget();
  stream.newest.reset();
  if (parameters_.clocks == ClockModel::Separate) return;
  past_.reset();  // as when a recording begins again
  // What the others have from before the jump would put all that follows into the past.
  for (Stream& other : streams_)
    while (!other.views.empty() &&
           detail::wrappingDifference(other.views.back().stamp, stamp) > parameters_.max_wait.count()) {
      if (other.views.back().payload) ++other.counts.unmatched;
      dropped.push_back(std::move(other.views.back()));
      other.views.pop_back();
    }
}

/** \brief The places of frames that were lost in a gap up to the newest stamp: the latest of them, as far as there is room. */
template <typename PayloadT>
void ViewSynchronizer<PayloadT>::addPlaces(Stream& stream, std::int64_t gap, std::int64_t lost,
                                           std::int64_t arrival) const {
  constexpr std::int64_t most = 1 << 20;  // more are none: the period is that of a burst
  if (lost > most || stream.views.size() + 1 >= parameters_.capacity) return;
  const std::size_t room = parameters_.capacity - 1 - stream.views.size();  // one is for the view
  const std::int64_t parts = lost + 1;
  for (std::int64_t k =
           parts - std::min<std::int64_t>(lost, static_cast<std::int64_t>(std::min<std::size_t>(room, most)));
       k <= lost; ++k) {
    const std::int64_t since_last = gap / parts * k + gap % parts * k / parts;
    stream.views.push_back({detail::wrappingSum(*stream.newest, since_last - gap), arrival, std::nullopt});
  }
}

template <typename PayloadT>
std::optional<SynchronizedSet<PayloadT>> ViewSynchronizer<PayloadT>::take() {
  std::deque<Waiting> dropped;
  const std::lock_guard<std::mutex> lock(mutex_);
  return select(dropped);
}

template <typename PayloadT>
std::optional<SynchronizedSet<PayloadT>> ViewSynchronizer<PayloadT>::wait(std::chrono::microseconds timeout) {
  const auto deadline =
      std::chrono::steady_clock::now() + std::max(detail::upToAYear(timeout), std::chrono::microseconds(0));
  std::deque<Waiting> dropped;
  std::unique_lock<std::mutex> lock(mutex_);
  for (;;) {
    std::optional<Set> set = select(dropped);
    const auto now = std::chrono::steady_clock::now();
    if (set || now >= deadline) return set;
    if (!dropped.empty()) {
      lock.unlock();
      dropped.clear();
      lock.lock();
      continue;
    }
    auto until = deadline;
    if (const std::optional<std::int64_t> oldest = oldestArrival()) {
      const std::chrono::microseconds waited(std::clamp<std::int64_t>(
          detail::wrappingDifference(clock_().count(), *oldest), 0, parameters_.max_wait.count()));
      until = std::min(until, now + std::max(parameters_.max_wait - waited, std::chrono::microseconds(1)));
    }
    pushed_.wait_until(lock, until);
  }
}

template <typename PayloadT>
SynchronizerStatistics ViewSynchronizer<PayloadT>::getStatistics() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  SynchronizerStatistics statistics = sets_;
  for (const Stream& stream : streams_) {
    statistics.cameras.push_back(stream.counts);
    statistics.cameras.back().waiting = static_cast<std::uint64_t>(std::count_if(
        stream.views.begin(), stream.views.end(), [](const Waiting& view) { return view.payload.has_value(); }));
    statistics.cameras.back().offset = std::chrono::microseconds(timeOf(stream, 0));
  }
  return statistics;
}

template <typename PayloadT>
std::int64_t ViewSynchronizer<PayloadT>::timeOf(const Stream& stream, std::int64_t stamp) const {
  return parameters_.clocks == ClockModel::Shared ? stamp : detail::wrappingSum(stamp, stream.offset.value());
}

template <typename PayloadT>
void ViewSynchronizer<PayloadT>::dropOldest(Stream& stream, std::uint64_t& count, std::deque<Waiting>& dropped) const {
  if (stream.views.front().payload) ++count;
  dropped.push_back(std::move(stream.views.front()));
  stream.views.pop_front();
}

/** \brief Views that are not after the last set. */
template <typename PayloadT>
void ViewSynchronizer<PayloadT>::dropPast(std::deque<Waiting>& dropped) {
  if (!past_) return;
  for (Stream& stream : streams_)
    while (!stream.views.empty() && detail::wrappingDifference(timeOf(stream, stream.views.front().stamp), *past_) <= 0)
      dropOldest(stream, stream.counts.unmatched, dropped);
}

template <typename PayloadT>
std::optional<std::int64_t> ViewSynchronizer<PayloadT>::oldestArrival() const {
  std::optional<std::int64_t> oldest;
  for (const Stream& stream : streams_)
    if (!stream.views.empty() && (!oldest || detail::wrappingDifference(stream.views.front().arrival, *oldest) < 0))
      oldest = stream.views.front().arrival;
  return oldest;
}

template <typename PayloadT>
std::optional<SynchronizedSet<PayloadT>> ViewSynchronizer<PayloadT>::select(std::deque<Waiting>& dropped) {
  dropPast(dropped);  // an estimate that has since become better may have put views there
  const std::optional<std::int64_t> oldest = oldestArrival();
  if (!oldest) return std::nullopt;
  const std::int64_t now = clock_().count();
  const bool overdue = detail::wrappingDifference(now, *oldest) >= parameters_.max_wait.count();
  std::size_t with_views = 0;
  for (const Stream& stream : streams_) {
    if (!overdue && stream.counts.waited_for && stream.views.empty()) return std::nullopt;
    if (!stream.views.empty()) ++with_views;
  }

  detail::ViewTimes times(streams_.size());  // from one of them on
  std::optional<std::int64_t> base;
  for (std::size_t c = 0; c < streams_.size(); ++c)
    for (const Waiting& view : streams_[c].views) {
      const std::int64_t time = timeOf(streams_[c], view.stamp);
      if (!base) base = time;
      times[c].push_back(detail::wrappingDifference(time, *base));
    }
  const std::vector<std::size_t> chosen =
      detail::fullestSet(times, 2 * static_cast<std::uint64_t>(parameters_.tolerance.count()));
  const auto places = static_cast<std::size_t>(
      std::count_if(chosen.begin(), chosen.end(), [](std::size_t position) { return position != detail::kNoView; }));
  if (places < with_views && !overdue) return std::nullopt;

  const detail::TimeRange range(times, chosen);
  Set set = assemble(chosen, dropped);
  set.spread = std::chrono::microseconds(range.spread());
  past_ = detail::wrappingSum(*base, range.middle());
  dropPast(dropped);
  const auto in_set = static_cast<std::size_t>(
      std::count_if(set.views.begin(), set.views.end(), [](const auto& view) { return view.has_value(); }));
  if (in_set == 0) return select(dropped);  // an instant that all of its cameras lost
  set.stamp = stampOf(*past_, now);
  if (overdue)
    for (std::size_t c = 0; c < streams_.size(); ++c)
      if (!set.views[c] && streams_[c].views.empty()) streams_[c].counts.waited_for = false;

  ++(in_set == streams_.size() ? sets_.complete_sets : sets_.incomplete_sets);
  total_spread_ += static_cast<double>(range.spread());
  sets_.largest_spread = std::max(sets_.largest_spread, set.spread);
  sets_.mean_spread = std::chrono::microseconds(
      static_cast<std::int64_t>(total_spread_ / static_cast<double>(sets_.complete_sets + sets_.incomplete_sets)));
  return set;
}

/** \brief Of a set that goes out now. */
template <typename PayloadT>
std::uint64_t ViewSynchronizer<PayloadT>::stampOf(std::int64_t time, std::int64_t now) {
  const auto isAfterLast = [this](std::int64_t stamp) {
    return !last_stamp_ || detail::wrappingDifference(stamp, *last_stamp_) > 0;
  };
  if (isAfterLast(time)) {
    ahead_ = 0;
  } else if (!isAfterLast(detail::wrappingSum(time, ahead_))) {
    const std::int64_t since = std::max<std::int64_t>(1, detail::wrappingDifference(now, last_set_at_));
    ahead_ = detail::wrappingDifference(detail::wrappingSum(*last_stamp_, since), time);
  }
  last_stamp_ = detail::wrappingSum(time, ahead_);
  last_set_at_ = now;
  return static_cast<std::uint64_t>(*last_stamp_);
}

/** \brief Takes the chosen views, and drops the ones before them. */
template <typename PayloadT>
SynchronizedSet<PayloadT> ViewSynchronizer<PayloadT>::assemble(const std::vector<std::size_t>& chosen,
                                                               std::deque<Waiting>& dropped) {
  Set set;
  set.views.resize(streams_.size());
  for (std::size_t c = 0; c < streams_.size(); ++c) {
    if (chosen[c] == detail::kNoView) continue;
    Stream& stream = streams_[c];
    for (std::size_t k = 0; k < chosen[c]; ++k) dropOldest(stream, stream.counts.unmatched, dropped);
    Waiting& view = stream.views.front();
    if (view.payload) {
      set.views[c] = SynchronizedView<PayloadT>{static_cast<std::uint64_t>(view.stamp), std::move(*view.payload)};
      ++stream.counts.used;
    }
    stream.views.pop_front();
  }
  return set;
}

}  // namespace fuse_flow
