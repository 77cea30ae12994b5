#pragma once

#include <pcl/exceptions.h>

#include <atomic>
#include <string>
#include <thread>

namespace fuse_flow {
namespace detail {

/** \brief Guards an object that only one thread may use at a time. A second thread gets an exception, in all builds. The check takes some
 *  nanoseconds per call; without it, errors by two threads would be silent and not reproducible. */
class OneThread {
 public:
  OneThread() = default;
  ///@{
  /** \brief No thread is inside a copy. */
  OneThread(const OneThread&) noexcept {}
  OneThread& operator=(const OneThread&) noexcept { return *this; }
  ///@}

  /** \brief While this object exists, the calling thread is inside. The same thread may enter again. */
  class Inside {
   public:
    /** \param object what is entered  \param owner the class, for the message  \throws pcl::PCLException if another thread is inside */
    Inside(OneThread& object, const char* owner) : object_(object) {
      std::thread::id there;  // nobody
      entered_ = object.thread_.compare_exchange_strong(there, std::this_thread::get_id(), std::memory_order_acquire);
      if (!entered_ && there != std::this_thread::get_id())
        throw pcl::PCLException(std::string(owner) +
                                ": two threads use one object at once; each needs an object of its own");
    }
    ~Inside() {
      if (entered_) object_.thread_.store(std::thread::id(), std::memory_order_release);
    }
    Inside(const Inside&) = delete;
    Inside& operator=(const Inside&) = delete;

   private:
    OneThread& object_;
    bool entered_;
  };

 private:
  std::atomic<std::thread::id> thread_{std::thread::id()};
};

}  // namespace detail
}  // namespace fuse_flow
