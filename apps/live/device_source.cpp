#include "live/device_source.h"

namespace fuse_flow::io {

DeviceSource::DeviceSource(std::unique_ptr<Device> device, OpenAgain open_again, const DeviceTiming& timing)
    : device_(std::move(device)),
      open_again_(std::move(open_again)),
      timing_(timing),
      name_(device_->name()),
      cameras_{device_->camera()},
      has_color_(device_->hasColor()),
      has_depth_(device_->hasDepth()),
      has_intrinsics_(device_->hasIntrinsics()) {
  warnings_ = device_->warnings();
}

DeviceSource::~DeviceSource() { stop(); }

void DeviceSource::start(const Receiver& receiver) {
  if (stopping_ || thread_.joinable()) return;
  receiver_ = receiver;
  device_->start();
  thread_ = std::thread([this] { run(); });
}

void DeviceSource::stop() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stopping_ = true;
  }
  stop_.notify_all();
  if (thread_.joinable()) thread_.join();
  device_.reset();
  running_ = false;
}

/** \brief Whether it is to stop, after a wait that stop() ends. */
bool DeviceSource::stopped(std::chrono::milliseconds wait) {
  std::unique_lock<std::mutex> lock(mutex_);
  return stop_.wait_for(lock, wait, [this] { return stopping_; });
}

void DeviceSource::say(const std::string& line) const {
  if (receiver_.notice) receiver_.notice(line);
}

void DeviceSource::run() {
  do {
    try {
      deliver();
      return;
    } catch (const std::exception& lost) {  // of a library, too: nothing may leave the thread
      device_.reset();
      say(std::string(lost.what()) + "; it is looked for again");
    }
  } while (openAgain());
}

/** \brief Until stop(). Throws if the device is gone. */
void DeviceSource::deliver() {
  using Clock = std::chrono::steady_clock;
  Clock::time_point last = Clock::now(), asked = last;
  bool said_silent = false;
  while (!stopped(std::chrono::milliseconds(0))) {
    const std::optional<DeviceImages> delivered = device_->wait(timing_.wait);
    const std::string notice = device_->notice();
    if (!notice.empty()) say(notice);
    const Clock::time_point now = Clock::now();
    if (delivered) {
      if (said_silent) say(name_ + ": delivers images again");
      said_silent = false;
      last = asked = now;
      receiver_.view({0, delivered->stamp, delivered->images});
      continue;
    }
    if (now - asked < timing_.silent) continue;
    asked = now;
    if (!device_->connected()) throw InputError(name_ + ": was unplugged");
    if (now - last < timing_.give_up || said_silent) continue;
    const std::string reason = device_->waitsFor();
    if (reason.empty()) throw InputError(name_ + ": is connected, but delivers no images");
    say(name_ + ": delivers no images: " + reason);
    said_silent = true;
  }
}

/** \brief Whether it delivers again; false: stop() came, or it is another camera now. */
bool DeviceSource::openAgain() {
  std::string said;
  while (!stopped(timing_.look_for)) {
    try {
      std::unique_ptr<Device> device = open_again_();
      if (!device) continue;
      if (!sameCalibration(device->camera(), cameras_[0])) {  // those who take the views know the former
        say(name_ + ": is back with another calibration, and not used any more; start again to use it");
        running_ = false;
        return false;
      }
      device->start();
      device_ = std::move(device);
      say(name_ + ": is back");
      return true;
    } catch (const std::exception& error) {
      if (said != error.what()) say(said = error.what());
    }
  }
  return false;
}

}  // namespace fuse_flow::io
