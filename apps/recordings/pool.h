#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace fuse_flow::io {

/** \brief Objects whose memory is used again once nobody holds them. They may be let go of on any thread, also after the pool is gone. */
template <typename T>
class Pool {
 public:
  /** \brief An object to be filled in, with the content of an earlier one where there is one. For one thread. */
  std::shared_ptr<T> next() {
    std::unique_ptr<T> object;
    {
      const std::lock_guard<std::mutex> lock(free_->mutex);
      if (!free_->objects.empty()) {
        object = std::move(free_->objects.back());
        free_->objects.pop_back();
      }
    }
    if (!object) {
      object = std::make_unique<T>();
      ++size_;
    }
    const auto give_back = [free = free_](T* used) {
      std::unique_ptr<T> owner(used);
      const std::lock_guard<std::mutex> lock(free->mutex);
      free->objects.push_back(std::move(owner));
    };
    return std::shared_ptr<T>(object.release(), give_back);
  }
  /** \brief Objects in memory. */
  std::size_t size() const { return size_; }

 private:
  struct Free {
    std::mutex mutex;
    std::vector<std::unique_ptr<T>> objects;
  };
  std::shared_ptr<Free> free_{std::make_shared<Free>()};
  std::size_t size_{0};
};

}  // namespace fuse_flow::io
