#pragma once

#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>

namespace fuse_flow::stream::foxglove {

/** \brief Tells a thread that waits for work to end, and waits for it. May be called again. \param mutex guards the rest
 *  \param stopped is set; the thread returns when it sees that  \param wanted what it waits for */
inline void endThread(std::mutex& mutex, bool& stopped, std::condition_variable& wanted, std::thread& thread) {
  std::thread ending;
  {
    const std::lock_guard<std::mutex> lock(mutex);
    stopped = true;
    ending.swap(thread);
  }
  wanted.notify_all();
  if (ending.joinable()) ending.join();
}

}  // namespace fuse_flow::stream::foxglove
