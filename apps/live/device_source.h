#pragma once

#include "live/camera_source.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace fuse_flow::io {

/** \brief What a device delivers at one instant. */
struct DeviceImages {
  std::uint64_t stamp{0};  ///< microseconds of the device's clock
  std::shared_ptr<const LoadedView> images;
};

/** \brief A camera that a library has opened. Its destructor stops the camera and gives it back. One thread at a time uses it. */
class Device {
 public:
  /** \param name in messages, "k4a:000123" */
  explicit Device(std::string name) : name_(std::move(name)) {}
  virtual ~Device() = default;
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  const std::string& name() const { return name_; }
  /** \brief The same as long as it is open; known before start(). */
  virtual const Camera& camera() const = 0;
  virtual bool hasColor() const = 0;
  virtual bool hasDepth() const { return true; }
  /** \brief Whether it knows its lens; else camera() has only the size of its images. */
  virtual bool hasIntrinsics() const { return true; }
  /** \brief What was assumed, one line each. */
  virtual std::vector<std::string> warnings() const { return {}; }
  /** \throws InputError if it cannot deliver */
  virtual void start() = 0;
  /** \brief Waits for the next images. \returns nothing if none came in this time  \throws InputError if it is gone: "k4a:0: was unplugged" */
  virtual std::optional<DeviceImages> wait(std::chrono::milliseconds longest) = 0;
  /** \brief Whether it is still there; asked when it delivers nothing. */
  virtual bool connected() = 0;
  /** \brief Why it may rightly deliver nothing: "waits for its master". Empty: it may not. */
  virtual std::string waitsFor() const { return {}; }
  /** \brief What is to be said of the last images, once; else empty. */
  virtual std::string notice() { return {}; }

 private:
  std::string name_;
};

/** \brief When a device that delivers nothing is looked after. */
struct DeviceTiming {
  std::chrono::milliseconds wait{200};       ///< longest that stop() waits for
  std::chrono::milliseconds silent{1000};    ///< without images: is it still connected?
  std::chrono::milliseconds give_up{5000};   ///< without images, though it is connected: it is closed and opened again
  std::chrono::milliseconds look_for{1000};  ///< between two attempts to open it again
};

/** \brief One device as a CameraSource, with a thread that waits for its images. If the device goes away, the thread closes it, and opens it again when
 *  it is back. */
class DeviceSource : public CameraSource {
 public:
  /** \brief Opens the same device, the one with the same serial number, again. \returns null while it is not connected \throws InputError if it
   *  is, but cannot be opened */
  using OpenAgain = std::function<std::unique_ptr<Device>()>;

  DeviceSource(std::unique_ptr<Device> device, OpenAgain open_again, const DeviceTiming& timing = {});
  ~DeviceSource() override;
  DeviceSource(const DeviceSource&) = delete;
  DeviceSource& operator=(const DeviceSource&) = delete;

  const std::vector<Camera>& cameras() const override { return cameras_; }
  bool hasDepth(std::size_t /*camera*/) const override { return has_depth_; }
  bool hasIntrinsics(std::size_t /*camera*/) const override { return has_intrinsics_; }
  bool hasColor(std::size_t /*camera*/) const override { return has_color_; }
  void start(const Receiver& receiver) override;
  void stop() override;
  bool running() const override { return running_; }

 private:
  void run();
  void deliver();
  bool openAgain();
  bool stopped(std::chrono::milliseconds wait);
  void say(const std::string& line) const;

  std::unique_ptr<Device> device_;
  OpenAgain open_again_;
  DeviceTiming timing_;
  std::string name_;
  std::vector<Camera> cameras_;
  bool has_color_, has_depth_, has_intrinsics_;
  Receiver receiver_;
  std::thread thread_;
  std::atomic<bool> running_{true};
  std::mutex mutex_;
  std::condition_variable stop_;
  bool stopping_{false};
};

}  // namespace fuse_flow::io
