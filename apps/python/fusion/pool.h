#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace fuse_flow::python {

/** \brief Memory that results are written into, and which comes back when Python has forgotten them: new memory would cost a frame more time
 *  than everything else between Python and C++. T is made once, and reused as it is. */
template <typename T>
class Pool : public std::enable_shared_from_this<Pool<T>> {
 public:
  std::shared_ptr<T> take() {
    std::unique_ptr<T> value;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (!free_.empty()) {
        value = std::move(free_.back());
        free_.pop_back();
      }
    }
    if (!value) value = std::make_unique<T>();
    return {value.release(), [pool = this->weak_from_this()](T* returned) {
              std::unique_ptr<T> owned(returned);
              if (const auto alive = pool.lock()) alive->giveBack(std::move(owned));
            }};
  }

 private:
  /** \brief As many as a loop has at a time that keeps the result before: more would hold memory that nobody needs. */
  static constexpr std::size_t kMost = 2;

  void giveBack(std::unique_ptr<T> value) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (free_.size() < kMost) free_.push_back(std::move(value));
  }

  std::mutex mutex_;
  std::vector<std::unique_ptr<T>> free_;
};

}  // namespace fuse_flow::python
