#include "live/prepared_instants.h"

#include <utility>

namespace fuse_flow::io {
namespace {

constexpr std::chrono::milliseconds kLook(20);  // after which the thread looks whether it is to end

}  // namespace

PreparedInstants::PreparedInstants(LiveRig& rig, Prepare prepare)
    : rig_(rig), prepare_(std::move(prepare)), thread_([this] { run(); }) {}

PreparedInstants::~PreparedInstants() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void PreparedInstants::run() {
  std::exception_ptr error;
  try {
    while (prepareNext()) {
    }
  } catch (...) {
    error = std::current_exception();
  }
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    error_ = error;
    ended_ = true;
  }
  changed_.notify_all();
}

/** \brief False: there is no more to do. */
bool PreparedInstants::prepareNext() {
  {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [this] { return ending_ || !ready_; });
  }
  const auto instant = std::make_shared<LiveInstant>();
  for (;;) {
    const bool more = rig_.running();  // before the look, or what came in between would be lost
    if (ending()) return false;
    if (rig_.next(kLook, *instant)) break;
    if (!more) return false;
  }
  prepare_(*instant);
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ready_ = instant;
  }
  changed_.notify_all();
  return true;
}

bool PreparedInstants::ending() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return ending_;
}

std::shared_ptr<LiveInstant> PreparedInstants::next(std::chrono::milliseconds timeout) {
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait_for(lock, timeout, [this] { return ready_ || ended_; });
  std::shared_ptr<LiveInstant> instant = std::move(ready_);
  ready_ = nullptr;
  if (!instant && error_) std::rethrow_exception(error_);
  lock.unlock();
  changed_.notify_all();
  return instant;
}

bool PreparedInstants::running() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return !ended_ || ready_ || error_;
}

}  // namespace fuse_flow::io
