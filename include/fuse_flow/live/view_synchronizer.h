#pragma once

#include <fuse_flow/impl/live/clock_offset.hpp>
#include <fuse_flow/impl/live/frame_period.hpp>
#include <fuse_flow/impl/live/wrapping.hpp>

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <vector>

namespace fuse_flow {

/** \brief How the stamps of different cameras relate. */
enum class ClockModel {
  Shared,   ///< one clock stamps every view, as with PTP or in a recording: stamps are compared as they are
  Separate  ///< each camera stamps by a clock of its own, whose offset and drift are estimated from when views arrive
};

/** \brief When views belong together, and how long one is waited for. Durations of more than a year count as one. */
struct SynchronizerParameters {
  /** \brief No view of a set is further from the set's stamp; > 0. Cameras that expose together: up to a quarter of their
   *  frame period; free-running ones: half of it. */
  std::chrono::microseconds tolerance{8000};
  /** \brief A view waits no longer for the other cameras'; > 0, and above the slowest camera's frame period: a slower camera
   *  than that is mostly missing. */
  std::chrono::microseconds max_wait{100000};
  /** \brief Views that wait, for each camera; ≥ 1. More frames than this in max_wait, and some are lost. */
  std::size_t capacity{8};
  /** \brief Whose clock stamps; set stamps are on the cameras' clock if it is shared, else on the host's. */
  ClockModel clocks{ClockModel::Separate};
  /** \brief The offset of a camera's clock is estimated over this, ClockModel::Separate only; > 0. An offset that grows by
   *  100 µs/s is behind by up to 1 ms over the default's 10 s. */
  std::chrono::microseconds offset_window{10000000};
};

/** \brief Throws pcl::BadArgumentException naming the parameter and its value if one is out of its range. */
inline void checkParameters(const SynchronizerParameters& parameters);

/** \brief What became of the views. */
struct SynchronizerStatistics {
  /** \brief Of one camera; received is the sum of used, overrun, unmatched, late, repeated and waiting. */
  struct Camera {
    std::uint64_t received{0};            ///< views that were pushed
    std::uint64_t used{0};                ///< went out in a set
    std::uint64_t overrun{0};             ///< dropped: as many as the capacity waited already
    std::uint64_t unmatched{0};           ///< dropped: a later set went out, or the camera restarted
    std::uint64_t late{0};                ///< dropped: came after the set of its time, or after its successor
    std::uint64_t repeated{0};            ///< dropped: the stamp of its predecessor
    std::uint64_t waiting{0};             ///< for the other cameras
    std::uint64_t restarts{0};            ///< times that stamps went back by more than max_wait
    std::chrono::microseconds offset{0};  ///< set stamp − the camera's stamp; 0 with ClockModel::Shared
    bool waited_for{true};                ///< false: has stalled, sets do without it
  };
  std::vector<Camera> cameras;                  ///< in the order of their numbers
  std::uint64_t complete_sets{0};               ///< with a view of every camera
  std::uint64_t incomplete_sets{0};             ///< with some cameras missing
  std::chrono::microseconds mean_spread{0};     ///< see SynchronizedSet::spread
  std::chrono::microseconds largest_spread{0};  ///< see SynchronizedSet::spread
};

/** \brief A camera's part of a set. */
template <typename PayloadT>
struct SynchronizedView {
  std::uint64_t stamp{0};  ///< as it was pushed
  PayloadT payload;        ///< as it was pushed
};

/** \brief The views of one instant. */
template <typename PayloadT>
struct SynchronizedSet {
  /** \brief The middle of its earliest and latest view, microseconds. It grows from set to set: after a shared clock has jumped
   *  back it goes on by the host's time, ahead of that clock. */
  std::uint64_t stamp{0};
  std::chrono::microseconds spread{0};  ///< from its earliest to its latest view; at most twice the tolerance
  /** \brief views[i] is camera i's; without a value where the camera is missing. */
  std::vector<std::optional<SynchronizedView<PayloadT>>> views;
};

/** \brief Brings the views of several cameras together by their stamps, as they arrive: grabbers push, from any thread, and
 *  whoever fuses takes sets.
 *
 *  \code
 *  fuse_flow::ViewSynchronizer<Cloud::ConstPtr> synchronizer(grabbers.size());
 *  // in the callback of grabber i:
 *  synchronizer.push(i, cloud->header.stamp, cloud);
 *  // in the thread that fuses:
 *  while (const auto set = synchronizer.wait(2s)) …
 *  \endcode
 *
 *  A set goes out as soon as every camera that is waited for has a view in it; if several could, the latest, so that a slow
 *  consumer skips frames instead of falling behind. Of cameras with different rates the slowest sets the pace; a frame that a
 *  camera has lost, by the rate at which it delivers, holds up no one. A view that has waited for max_wait goes out with
 *  what there is, and a camera that has delivered nothing by then has stalled: no set waits for it until it delivers again.
 *  No more than capacity views of a camera are kept, with the places of lost ones, the oldest give way. push() never waits for a consumer: both hold the
 *  lock for bookkeeping only, and drop views outside of it.
 *
 *  Any number of threads may use one object. Objects share nothing.
 *
 *  PayloadT is what owns the images, such as a cloud's ConstPtr; it must be movable. */
template <typename PayloadT>
class ViewSynchronizer {
 public:
  using Set = SynchronizedSet<PayloadT>;                     ///< what is taken
  using Clock = std::function<std::chrono::microseconds()>;  ///< the host's time; called from every thread

  /** \param cameras how many; > 0  \param parameters see there  \param clock tells when views arrive and how long they have
   *  waited; default std::chrono::steady_clock  \throws pcl::BadArgumentException for a value out of range */
  inline explicit ViewSynchronizer(std::size_t cameras, const SynchronizerParameters& parameters = {},
                                   Clock clock = steadyTime);

  /** \brief Hand over a view. A stamp that goes back by up to max_wait is out of order and dropped; by more, the camera has
   *  restarted. Any number is a stamp; one that is 2⁶³ µs or more ahead of its predecessor lies before it.
   *  \param camera its number, from 0  \param stamp when it was exposed, microseconds of the camera's clock
   *  \param payload the view  \throws pcl::BadArgumentException if there is no such camera */
  inline void push(std::size_t camera, std::uint64_t stamp, PayloadT payload);

  /** \brief The latest set that is ready, if there is one. */
  inline std::optional<Set> take();

  /** \brief As take(), but waits for a set, up to a time.  \param timeout from now on; more than a year counts as one */
  inline std::optional<Set> wait(std::chrono::microseconds timeout);

  /** \brief Since construction. */
  inline SynchronizerStatistics getStatistics() const;

 private:
  struct Waiting {
    std::int64_t stamp;               // µs, the camera's clock
    std::int64_t arrival;             // µs, the host's
    std::optional<PayloadT> payload;  // none: the place of a frame that the camera lost
  };
  struct Stream {
    explicit Stream(std::chrono::microseconds window) : offset(window.count()) {}
    std::deque<Waiting> views;  // oldest first
    detail::ClockOffset offset;
    detail::FramePeriod period;
    std::optional<std::int64_t> newest;  // stamp
    SynchronizerStatistics::Camera counts;
  };

  static inline std::chrono::microseconds steadyTime();
  inline std::int64_t timeOf(const Stream& stream, std::int64_t stamp) const;
  inline bool accept(Stream& stream, std::int64_t stamp, std::int64_t arrival, std::deque<Waiting>& dropped);
  inline void restart(Stream& stream, std::int64_t stamp, std::deque<Waiting>& dropped);
  inline void addPlaces(Stream& stream, std::int64_t gap, std::int64_t lost, std::int64_t arrival) const;
  inline std::uint64_t stampOf(std::int64_t time, std::int64_t now);
  inline void dropOldest(Stream& stream, std::uint64_t& count, std::deque<Waiting>& dropped) const;
  inline void dropPast(std::deque<Waiting>& dropped);
  inline std::optional<std::int64_t> oldestArrival() const;
  inline std::optional<Set> select(std::deque<Waiting>& dropped);
  inline Set assemble(const std::vector<std::size_t>& chosen, std::deque<Waiting>& dropped);

  SynchronizerParameters parameters_;
  Clock clock_;
  mutable std::mutex mutex_;
  std::condition_variable pushed_;
  // What follows is guarded by the mutex.
  std::deque<Stream> streams_;        // not a vector, which wants to copy what it cannot move without a throw
  std::optional<std::int64_t> past_;  // the time of the last set: what is not after it is late
  std::optional<std::int64_t> last_stamp_;
  std::int64_t last_set_at_{0};  // µs, the host's
  std::int64_t ahead_{0};        // stamps of sets − their times; 0 unless a shared clock has jumped back
  SynchronizerStatistics sets_;  // of the sets; the cameras' are in their streams
  double total_spread_{0};       // µs
};

}  // namespace fuse_flow

#include <fuse_flow/impl/live/view_synchronizer.hpp>
