#include "recordings/read_ahead.h"

#include <system_error>
#include <utility>

namespace fuse_flow::io {

ReadAhead::ReadAhead(Recording& recording, std::vector<std::size_t> frames, std::size_t ahead)
    : recording_(recording), frames_(std::move(frames)), ahead_(ahead) {
  const std::size_t threads = recording.readsConcurrently() ? ahead : 1;
  try {
    while (threads_.size() < threads) threads_.emplace_back([this] { run(); });
  } catch (const std::system_error&) {
    if (threads_.empty()) throw;  // else those that were started read everything, later
  } catch (...) {
    end();
    throw;
  }
}

ReadAhead::~ReadAhead() { end(); }

void ReadAhead::end() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void ReadAhead::run() {
  for (;;) {
    Read read;
    std::size_t place = 0;
    {
      std::unique_lock<std::mutex> lock(mutex_);
      changed_.wait(lock, [this] { return ending_ || begun_ == frames_.size() || begun_ < taken_ + ahead_; });
      if (ending_ || begun_ == frames_.size()) return;
      place = begun_++;
      if (!spare_.empty()) {
        read.frame = std::move(spare_.back());
        spare_.pop_back();
      }
    }
    try {
      recording_.read(frames_[place], read.frame);
    } catch (...) {
      read.error = std::current_exception();
    }
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      ending_ = ending_ || read.error;  // those behind it are not asked for
      ready_.emplace(place, std::move(read));
    }
    changed_.notify_all();
  }
}

void ReadAhead::next(LoadedFrame& frame) {
  Read read;
  {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [this] { return ready_.count(taken_) > 0; });
    const auto first = ready_.find(taken_);
    read = std::move(first->second);
    ready_.erase(first);
    ++taken_;
    if (spare_.size() < ahead_) spare_.push_back(std::move(frame));
  }
  changed_.notify_all();
  frame = std::move(read.frame);
  if (read.error) std::rethrow_exception(read.error);
}

}  // namespace fuse_flow::io
