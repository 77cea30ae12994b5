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
  Shared,   ///< one clock stamps every view, as with PTP or in a recording; stamps are compared directly
  Separate  ///< each camera has its own clock; offset and drift are estimated from the arrival times of the views
};

/** \brief When views belong together, and how long the synchroniser waits for a view. A duration of more than a year counts as one year. */
struct SynchronizerParameters {
  /** \brief Largest difference between the stamp of a view and the stamp of its set; > 0. For cameras that expose together: at most a
   *  quarter of their frame period. For free-running cameras: half of it. */
  std::chrono::microseconds tolerance{8000};
  /** \brief Longest time that a view waits for the views of other cameras; > 0. It should be above the frame period of the slowest camera;
   *  otherwise that camera is missing from most sets. */
  std::chrono::microseconds max_wait{100000};
  /** \brief Largest number of waiting views of each camera; ≥ 1. If more views than this arrive within max_wait, some are lost. */
  std::size_t capacity{8};
  /** \brief Whether the cameras share a clock. The stamps of sets use the clock of the cameras if it is shared, else the clock of the
   *  host. */
  ClockModel clocks{ClockModel::Separate};
  /** \brief Time window in which the offset of a camera's clock is estimated, only with ClockModel::Separate; > 0. If an offset grows by
   *  100 µs/s, the estimate lags by up to 1 ms with the default of 10 s. */
  std::chrono::microseconds offset_window{10000000};
};

/** \brief Throws pcl::BadArgumentException naming the parameter and its value if one is out of its range. */
inline void checkParameters(const SynchronizerParameters& parameters);

/** \brief Counts of the views and sets. */
struct SynchronizerStatistics {
  /** \brief Counts of one camera. received is the sum of used, overrun, unmatched, late, repeated and waiting. */
  struct Camera {
    std::uint64_t received{0};            ///< views that were pushed
    std::uint64_t used{0};                ///< delivered in a set
    std::uint64_t overrun{0};             ///< dropped: the number of waiting views had reached the capacity
    std::uint64_t unmatched{0};           ///< dropped: a later set was delivered, or the camera restarted
    std::uint64_t late{0};                ///< dropped: arrived after the set of its time, or after its successor
    std::uint64_t repeated{0};            ///< dropped: has the stamp of its predecessor
    std::uint64_t waiting{0};             ///< waiting for the other cameras
    std::uint64_t restarts{0};            ///< how often stamps went back by more than max_wait
    std::chrono::microseconds offset{0};  ///< set stamp − the camera's stamp; 0 with ClockModel::Shared
    bool waited_for{true};                ///< false: the camera has stalled, and sets do not wait for it
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
  /** \brief Middle between the stamps of its earliest and its latest view, microseconds. It grows from set to set. After a shared clock has
   *  jumped back, it continues with the host's time, and is then ahead of that clock. */
  std::uint64_t stamp{0};
  std::chrono::microseconds spread{0};  ///< from its earliest to its latest view; at most twice the tolerance
  /** \brief views[i] is the view of camera i; it has no value if the camera is missing. */
  std::vector<std::optional<SynchronizedView<PayloadT>>> views;
};

/** \brief Groups the views of several cameras into sets by their stamps. Grabbers push views from any thread; the thread that fuses takes
 *  sets.
 *
 *  \code
 *  fuse_flow::ViewSynchronizer<Cloud::ConstPtr> synchronizer(grabbers.size());
 *  // in the callback of grabber i:
 *  synchronizer.push(i, cloud->header.stamp, cloud);
 *  // in the thread that fuses:
 *  while (const auto set = synchronizer.wait(2s))
 *  … \endcode
 *
 *  A set is ready as soon as every camera that it waits for has a view in it. If several sets are ready, the latest one is delivered, so a
 *  slow consumer skips frames and does not fall behind. If cameras have different rates, the slowest camera determines the rate of the
 *  sets. The synchroniser detects lost frames by the rate of the camera, and no set waits for them. When a view has waited for max_wait,
 *  its set is delivered without the missing views. A camera that has delivered nothing by then has stalled: no set waits for it until it
 *  delivers again. At most capacity views of a camera are kept, lost frames included; the oldest are dropped first. push() never waits for
 *  a consumer: both hold the lock only for bookkeeping, and free views outside the lock.
 *
 *  Any number of threads may use one object. Objects share nothing.
 *
 *  PayloadT owns the images, such as the ConstPtr of a cloud; it must be movable. */
template <typename PayloadT>
class ViewSynchronizer {
 public:
  using Set = SynchronizedSet<PayloadT>;                     ///< what is taken
  using Clock = std::function<std::chrono::microseconds()>;  ///< the host's time; called from every thread

  /** \param cameras number of cameras; > 0 \param parameters see SynchronizerParameters \param clock the host's time, for arrival and
   *  waiting times; default std::chrono::steady_clock  \throws pcl::BadArgumentException for a value out of range */
  inline explicit ViewSynchronizer(std::size_t cameras, const SynchronizerParameters& parameters = {},
                                   Clock clock = steadyTime);

  /** \brief Hands over a view. If its stamp goes back by at most max_wait, the view is out of order and is dropped. If it goes back by
   *  more, the camera has restarted. Every number is a valid stamp. A stamp that is 2⁶³ µs or more ahead of its predecessor counts as
   *  earlier.
   *  \param camera its number, from 0 \param stamp time of exposure, microseconds of the camera's clock
   *  \param payload the view  \throws pcl::BadArgumentException if there is no such camera */
  inline void push(std::size_t camera, std::uint64_t stamp, PayloadT payload);

  /** \brief As push(), for a view that was on its way, or in a queue, since it arrived at the host.  \param arrival when it arrived, by the
   *  clock that the constructor was given; a time in the future counts as now */
  inline void push(std::size_t camera, std::uint64_t stamp, PayloadT payload, std::chrono::microseconds arrival);

  /** \brief The latest set that is ready, if there is one. */
  inline std::optional<Set> take();

  /** \brief As take(), but waits for a set. \param timeout longest time to wait; more than a year counts as one year */
  inline std::optional<Set> wait(std::chrono::microseconds timeout);

  /** \brief Counts since construction. */
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
  // The mutex guards the following members.
  std::deque<Stream> streams_;        // not a vector, which copies elements whose move constructor may throw
  std::optional<std::int64_t> past_;  // the time of the last set: views that are not later are late
  std::optional<std::int64_t> last_stamp_;
  std::int64_t last_set_at_{0};  // µs, the host's
  std::int64_t ahead_{0};        // stamps of sets − their times; 0 unless a shared clock has jumped back
  SynchronizerStatistics sets_;  // of the sets; the counts of cameras are in their streams
  double total_spread_{0};       // µs
};

}  // namespace fuse_flow

#include <fuse_flow/impl/live/view_synchronizer.hpp>
