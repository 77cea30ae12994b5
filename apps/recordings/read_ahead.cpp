#include "recordings/read_ahead.h"

#include <utility>

namespace fuse_flow::io {

ReadAhead::ReadAhead(Recording& recording, std::vector<std::size_t> frames, std::size_t ahead)
    : recording_(recording), frames_(std::move(frames)), ahead_(ahead), thread_([this] { run(); }) {}

ReadAhead::~ReadAhead() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void ReadAhead::run() {
  for (const std::size_t number : frames_) {
    Read read;
    {
      std::unique_lock<std::mutex> lock(mutex_);
      changed_.wait(lock, [this] { return ending_ || ready_.size() < ahead_; });
      if (ending_) return;
      if (!spare_.empty()) {
        read.frame = std::move(spare_.back());
        spare_.pop_back();
      }
    }
    try {
      recording_.read(number, read.frame);
    } catch (...) {
      read.error = std::current_exception();
    }
    const bool failed = read.error != nullptr;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      ready_.push_back(std::move(read));
    }
    changed_.notify_all();
    if (failed) return;
  }
}

void ReadAhead::next(LoadedFrame& frame) {
  Read read;
  {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [this] { return !ready_.empty(); });
    read = std::move(ready_.front());
    ready_.pop_front();
    if (spare_.size() < ahead_) spare_.push_back(std::move(frame));
  }
  changed_.notify_all();
  frame = std::move(read.frame);
  if (read.error) std::rethrow_exception(read.error);
}

}  // namespace fuse_flow::io
