#include "sinks/background_sink.h"

#include <utility>

namespace fuse_flow::io {

BackgroundSink::BackgroundSink(std::shared_ptr<FrameSink> sink, std::size_t waiting, WhenFull when_full)
    : sink_(std::move(sink)), most_(waiting), when_full_(when_full), thread_([this] { run(); }) {}

BackgroundSink::~BackgroundSink() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void BackgroundSink::run() {
  for (;;) {
    std::shared_ptr<const FusedFrame> frame;
    {
      std::unique_lock<std::mutex> lock(mutex_);
      changed_.wait(lock, [this] { return ending_ || !waiting_.empty(); });
      if (waiting_.empty()) return;
      frame = std::move(waiting_.front());
      waiting_.pop_front();
      working_ = true;
    }
    std::exception_ptr error;
    try {
      sink_->take(frame);
    } catch (...) {
      error = std::current_exception();
    }
    frame.reset();  // before somebody who waits looks for its memory
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      working_ = false;
      if (error) {
        error_ = error;
        waiting_.clear();
      }
    }
    changed_.notify_all();
    if (error) return;
  }
}

void BackgroundSink::take(const std::shared_ptr<const FusedFrame>& frame) {
  {
    std::unique_lock<std::mutex> lock(mutex_);
    if (when_full_ == WhenFull::Wait) changed_.wait(lock, [this] { return error_ || waiting_.size() < most_; });
    if (error_) std::rethrow_exception(error_);
    if (waiting_.size() >= most_) {
      ++dropped_;
      return;
    }
    waiting_.push_back(frame);
  }
  changed_.notify_all();
}

void BackgroundSink::drain() {
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait(lock, [this] { return error_ || (waiting_.empty() && !working_); });
  if (error_) std::rethrow_exception(error_);
}

std::size_t BackgroundSink::dropped() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return dropped_;
}

std::vector<std::string> BackgroundSink::finish() {
  drain();
  return sink_->finish();
}

}  // namespace fuse_flow::io
