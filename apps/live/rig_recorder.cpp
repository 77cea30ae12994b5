#include "live/rig_recorder.h"

#include <fuse_flow/impl/host/parallel.hpp>

#include <chrono>
#include <utility>

namespace fuse_flow::io {

RigRecorder::RigRecorder(const std::string& path, const std::vector<Camera>& cameras,
                         const std::vector<bool>& has_color, const Options& options)
    : options_(options), messages_(path, cameras, has_color, options.messages) {
  const int threads = host::resolveThreads(static_cast<int>(options_.threads));
  try {
    for (int k = 0; k < threads; ++k) compressing_.emplace_back(&RigRecorder::compress, this);
    writing_ = std::thread(&RigRecorder::write, this);
  } catch (...) {  // a thread cannot be started
    abandon();
    throw;
  }
}

RigRecorder::RigRecorder(const std::string& path, LiveRig& rig, const Options& options)
    : RigRecorder(path, rig.cameras(), rig.colored(), options) {
  rig.setListener([this](std::size_t camera, std::uint64_t time, const CameraView& view) {
    take(camera, static_cast<Nanoseconds>(time) * 1000, view.images);
  });
}

RigRecorder::~RigRecorder() { abandon(); }

void RigRecorder::abandon() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ending_ = abandoned_ = true;
  }
  taken_.notify_all();
  compressed_.notify_all();
  written_to_disk_.notify_all();
  for (std::thread& thread : compressing_)
    if (thread.joinable()) thread.join();
  if (writing_.joinable()) writing_.join();
}

std::size_t RigRecorder::bytesOf(const LoadedView& images) {
  return images.depth16.data.size() * sizeof(std::uint16_t) + images.depth32.data.size() * sizeof(float) +
         images.color.data.size() * sizeof(Rgb8);
}

void RigRecorder::take(std::size_t camera, Nanoseconds time, std::shared_ptr<const LoadedView> images) {
  {
    std::unique_lock<std::mutex> lock(mutex_);
    const auto full = [&] { return waiting_ > 0 && waiting_ + bytesOf(*images) > options_.most_waiting; };
    if (options_.waits) written_to_disk_.wait(lock, [&] { return !full() || error_ || ending_; });
    if (error_ || ending_) return;
    confidence_ = confidence_ || !images->confidence.empty();
    if (full()) {
      ++lost_;
      return;
    }
    waiting_ += bytesOf(*images);
    jobs_.push_back({next_number_++, camera, time, std::move(images)});
  }
  taken_.notify_one();
}

void RigRecorder::compress() {
  std::unique_lock<std::mutex> lock(mutex_);
  for (;;) {
    taken_.wait(lock, [this] { return !jobs_.empty() || ending_; });
    if (abandoned_ || jobs_.empty()) return;
    Job job = std::move(jobs_.front());
    jobs_.pop_front();
    lock.unlock();
    Ready ready;
    std::exception_ptr error;
    try {
      ready.messages = messages_.encode(job.camera, job.time, *job.images);
    } catch (...) {
      error = std::current_exception();
    }
    ready.bytes = bytesOf(*job.images);
    job.images.reset();
    lock.lock();
    if (error && !error_) error_ = error;
    ready_.emplace(job.number, std::move(ready));
    if (job.number == next_written_ || error) compressed_.notify_one();
    if (error) written_to_disk_.notify_all();  // who waits for room waits in vain
  }
}

void RigRecorder::write() {
  constexpr std::chrono::milliseconds often(500);  // what a program that is killed loses
  auto flushed = std::chrono::steady_clock::now();
  std::unique_lock<std::mutex> lock(mutex_);
  for (;;) {
    const auto is_ready = [this] { return !ready_.empty() && ready_.begin()->first == next_written_; };
    compressed_.wait_until(lock, flushed + often, [&] {
      return is_ready() || abandoned_ || error_ || (ending_ && next_written_ == next_number_);
    });
    if (abandoned_ || error_) return;
    Ready ready;
    const bool any = is_ready();
    if (any) {
      ready = std::move(ready_.begin()->second);
      ready_.erase(ready_.begin());
    } else if (ending_ && next_written_ == next_number_) {
      return;
    }
    lock.unlock();
    std::exception_ptr error;
    try {
      messages_.write(ready.messages);
      if (const auto now = std::chrono::steady_clock::now(); now >= flushed + often) {
        messages_.flush();
        flushed = now;
      }
    } catch (...) {
      error = std::current_exception();
    }
    lock.lock();
    if (any) {
      ++next_written_;
      waiting_ -= ready.bytes;
    }
    if (error) {
      error_ = error;
      jobs_.clear();
      ready_.clear();
    }
    written_to_disk_.notify_all();
  }
}

void RigRecorder::check() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (error_) std::rethrow_exception(error_);
}

void RigRecorder::finish() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ending_ = true;
  }
  taken_.notify_all();
  compressed_.notify_all();
  for (std::thread& thread : compressing_) thread.join();
  compressing_.clear();
  compressed_.notify_all();
  writing_.join();
  check();
  messages_.finish();
}

std::vector<std::string> RigRecorder::leftOut() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!confidence_) return {};
  return {"the cameras' images of confidence have no place in such a file, and are left out"};
}

std::uint64_t RigRecorder::written() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return next_written_;
}

std::uint64_t RigRecorder::lost() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return lost_;
}

}  // namespace fuse_flow::io
