#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <utility>

namespace fuse_flow::viewing {

/** \brief Hands values from one thread to another and holds one at most: what nobody has taken when the next one comes is
 *  dropped. So a slow taker misses values, and no queue grows. */
template <typename T>
class LatestSlot {
 public:
  /** \brief Replaces what is there. */
  void put(T value) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      value_ = std::move(value);
    }
    filled_.notify_all();
  }

  /** \brief Without waiting; absent if there is nothing. */
  std::optional<T> take() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return std::exchange(value_, std::nullopt);
  }

  /** \brief Waits for a value; absent once the slot is closed. */
  std::optional<T> waitAndTake() {
    std::unique_lock<std::mutex> lock(mutex_);
    filled_.wait(lock, [this] { return value_ || closed_; });
    if (closed_) return std::nullopt;
    return std::exchange(value_, std::nullopt);
  }

  /** \brief As waitAndTake(), but absent also if nothing comes in that time. */
  std::optional<T> waitAndTake(std::chrono::milliseconds timeout) {
    std::unique_lock<std::mutex> lock(mutex_);
    filled_.wait_for(lock, timeout, [this] { return value_ || closed_; });
    return std::exchange(value_, std::nullopt);
  }

  /** \brief Ends every wait, now and later. */
  void close() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      closed_ = true;
    }
    filled_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable filled_;
  std::optional<T> value_;
  bool closed_{false};
};

}  // namespace fuse_flow::viewing
