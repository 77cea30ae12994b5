#include "live/device_kinds.h"

#ifdef FUSE_FLOW_WITH_K4A

#include "live/device_conversions.h"
#include "live/device_source.h"
#include "recordings/images/jpeg_decode.h"
#include "recordings/streams/azure_kinect.h"

#include <k4a/k4a.h>

#include <cstdlib>
#include <map>
#include <type_traits>
#include <utility>

namespace fuse_flow::io {
namespace {

template <typename Handle, void (*release)(Handle)>
struct K4aRelease {
  void operator()(Handle handle) const { release(handle); }
};
template <typename Handle, void (*release)(Handle)>
using K4aOwned = std::unique_ptr<std::remove_pointer_t<Handle>, K4aRelease<Handle, release>>;
using K4aHandle = K4aOwned<k4a_device_t, k4a_device_close>;
using K4aCapture = K4aOwned<k4a_capture_t, k4a_capture_release>;
using K4aImage = K4aOwned<k4a_image_t, k4a_image_release>;

/** \brief Only one thread at a time tries which devices can be opened: one that another tries cannot. */
std::mutex& k4aMutex() {
  static std::mutex mutex;
  return mutex;
}

/** \brief How many devices are plugged in. Comes before all else that is asked of the library, which reads its environment then: unless a user wants
 *  its log, it must not be in standard output, where it is by default; a handler of messages does not change that. */
unsigned k4aCount() {
  static const int quiet = setenv("K4A_ENABLE_LOG_TO_STDOUT", "0", 0);
  (void)quiet;
  return k4a_device_get_installed_count();
}

/** \brief Null if it is in use, or may not be used. */
K4aHandle openK4aHandle(unsigned index) {
  k4a_device_t handle = nullptr;
  if (k4a_device_open(index, &handle) != K4A_RESULT_SUCCEEDED) return nullptr;
  return K4aHandle(handle);
}

std::string k4aSerial(k4a_device_t handle) {
  std::size_t size = 0;  // with its zero at the end
  if (k4a_device_get_serialnum(handle, nullptr, &size) != K4A_BUFFER_RESULT_TOO_SMALL || size == 0) return {};
  std::string serial(size, '\0');
  if (k4a_device_get_serialnum(handle, serial.data(), &size) != K4A_BUFFER_RESULT_SUCCEEDED) return {};
  return serial.substr(0, serial.find('\0'));
}

constexpr const char* kK4aCannotOpen =
    "it is in use, or its user may not use USB devices, which the rules of libk4a for udev allow";

std::vector<ConnectedDevice> k4aList() {
  const std::lock_guard<std::mutex> lock(k4aMutex());
  std::vector<ConnectedDevice> list;
  const unsigned count = k4aCount();
  for (unsigned index = 0; index < count; ++index) {
    const K4aHandle handle = openK4aHandle(index);
    const std::string number = "k4a:" + std::to_string(index);
    const std::string serial = handle ? k4aSerial(handle.get()) : "";
    if (serial.empty())
      list.push_back({number, std::string("Azure Kinect; ") + kK4aCannotOpen});
    else
      list.push_back({"k4a:" + serial, "Azure Kinect, " + number});
  }
  return list;
}

/** \brief Null if none has this serial number that could be opened. */
K4aHandle openK4aSerial(const std::string& serial) {
  const std::lock_guard<std::mutex> lock(k4aMutex());
  const unsigned count = k4aCount();
  for (unsigned index = 0; index < count; ++index) {
    K4aHandle handle = openK4aHandle(index);
    if (handle && k4aSerial(handle.get()) == serial) return handle;
  }
  return nullptr;
}

/** \brief The part of each device in a chain of synchronisation cables; of all devices that this process opened. */
struct K4aChain {
  std::mutex mutex;
  std::map<std::string, unsigned> subordinates;  ///< by serial number: which in the order of opening, from 1
  int not_started{0};                            ///< subordinates that were opened, but do not yet listen to the master
};

K4aChain& k4aChain() {
  static K4aChain chain;
  return chain;
}

/** \brief A subordinate that does not listen yet, as long as it lives. */
class K4aNotStarted {
 public:
  K4aNotStarted() { add(1); }
  ~K4aNotStarted() { add(-1); }
  K4aNotStarted(const K4aNotStarted&) = delete;
  K4aNotStarted& operator=(const K4aNotStarted&) = delete;

 private:
  static void add(int count) {
    const std::lock_guard<std::mutex> lock(k4aChain().mutex);
    k4aChain().not_started += count;
  }
};

class K4aDevice : public Device {
 public:
  K4aDevice(K4aHandle handle, const std::string& serial) : Device("k4a:" + serial), handle_(std::move(handle)) {
    camera_ = azureKinectCamera(name() + ": its calibration", calibration(), {"NFOV_UNBINNED", "720P"});
    camera_.name = cameraNameOf(name());
    readJacks(serial);
  }
  ~K4aDevice() override {
    if (started_) k4a_device_stop_cameras(handle_.get());
  }

  const Camera& camera() const override { return camera_; }
  bool hasColor() const override { return true; }
  std::vector<std::string> warnings() const override { return warnings_; }

  void start() override {
    if (mode_ == K4A_WIRED_SYNC_MODE_MASTER) return;  // when all subordinates listen: see wait()
    startCameras();
    not_started_.reset();
  }

  std::optional<DeviceImages> wait(std::chrono::milliseconds longest) override {
    if (!started_ && !mayStart(longest)) return {};
    if (!started_) startCameras();
    k4a_capture_t taken = nullptr;
    const k4a_wait_result_t result =
        k4a_device_get_capture(handle_.get(), &taken, static_cast<std::int32_t>(longest.count()));
    if (result == K4A_WAIT_RESULT_TIMEOUT) return {};
    if (result != K4A_WAIT_RESULT_SUCCEEDED) throw InputError(name() + ": was unplugged, or its USB failed");
    const K4aCapture capture(taken);
    const K4aImage depth(k4a_capture_get_depth_image(taken)), color(k4a_capture_get_color_image(taken));
    if (!depth) return {};
    const auto images = std::make_shared<LoadedView>();
    copyDepth(depth.get(), images->depth16);
    if (color) decode(color.get(), images->color);
    return DeviceImages{k4a_image_get_device_timestamp_usec(depth.get()), images};
  }

  bool connected() override { return true; }  // where it is not, wait() fails
  std::string waitsFor() const override {
    if (mode_ == K4A_WIRED_SYNC_MODE_SUBORDINATE)
      return "its Sync In has a cable, so it waits for its master; start the master, or take the cable out";
    return started_ ? "" : "it is a master, and waits until the subordinates are started";
  }
  std::string notice() override { return std::exchange(notice_, {}); }

 private:
  std::string calibration() const {
    std::size_t size = 0;
    std::string json;
    if (k4a_device_get_raw_calibration(handle_.get(), nullptr, &size) == K4A_BUFFER_RESULT_TOO_SMALL) {
      json.resize(size);
      if (k4a_device_get_raw_calibration(handle_.get(), reinterpret_cast<std::uint8_t*>(json.data()), &size) ==
          K4A_BUFFER_RESULT_SUCCEEDED)
        return json;
    }
    throw InputError(name() + ": its calibration cannot be read from the device");
  }

  /** \brief A cable in a jack says which part a device has. */
  void readJacks(const std::string& serial) {
    bool in = false, out = false;
    if (k4a_device_get_sync_jack(handle_.get(), &in, &out) != K4A_RESULT_SUCCEEDED) {
      warnings_.push_back(name() + ": its synchronisation jacks cannot be read; it runs unsynchronised");
      return;
    }
    if (in) {
      mode_ = K4A_WIRED_SYNC_MODE_SUBORDINATE;
      not_started_ = std::make_unique<K4aNotStarted>();
      K4aChain& chain = k4aChain();
      const std::lock_guard<std::mutex> lock(chain.mutex);
      const auto place = static_cast<unsigned>(chain.subordinates.size()) + 1;
      constexpr unsigned apart = 160;  // µs, which the infrared flashes of one device take
      delay_ = apart * chain.subordinates.emplace(serial, place).first->second;
      warnings_.push_back(name() + ": is a subordinate, since its Sync In has a cable; it exposes " +
                          std::to_string(delay_) + " us after the master");
    } else if (out) {
      mode_ = K4A_WIRED_SYNC_MODE_MASTER;
      warnings_.push_back(name() +
                          ": is the master, since only its Sync Out has a cable; its exposure is automatic, which may "
                          "move the instant of its colour images");
    }
  }

  /** \brief Whether all subordinates listen, which must come first; after a wait if not. */
  static bool mayStart(std::chrono::milliseconds longest) {
    const auto ready = [] {
      const std::lock_guard<std::mutex> lock(k4aChain().mutex);
      return k4aChain().not_started == 0;
    };
    if (ready()) return true;
    std::this_thread::sleep_for(longest);
    return ready();
  }

  void startCameras() {
    k4a_device_configuration_t configuration = K4A_DEVICE_CONFIG_INIT_DISABLE_ALL;
    configuration.color_format = K4A_IMAGE_FORMAT_COLOR_MJPG;
    configuration.color_resolution = K4A_COLOR_RESOLUTION_720P;
    configuration.depth_mode = K4A_DEPTH_MODE_NFOV_UNBINNED;
    configuration.camera_fps = K4A_FRAMES_PER_SECOND_30;
    configuration.synchronized_images_only = true;
    configuration.wired_sync_mode = mode_;
    configuration.subordinate_delay_off_master_usec = delay_;
    if (k4a_device_start_cameras(handle_.get(), &configuration) != K4A_RESULT_SUCCEEDED)
      throw InputError(name() +
                       ": cannot be started; it needs USB 3, libdepthengine beside libk4a, and a display (DISPLAY) for "
                       "OpenGL");
    started_ = true;
  }

  void copyDepth(k4a_image_t image, DepthImage& into) const {
    const int width = k4a_image_get_width_pixels(image), height = k4a_image_get_height_pixels(image);
    if (width != camera_.intrinsics.width || height != camera_.intrinsics.height ||
        k4a_image_get_format(image) != K4A_IMAGE_FORMAT_DEPTH16)
      throw InputError(name() + ": delivers depth of another size or format than was asked for");
    copyRows(k4a_image_get_buffer(image), static_cast<std::size_t>(k4a_image_get_stride_bytes(image)), width, height,
             into);
  }

  /** \brief USB damages an image now and then: its view then has no colour. */
  void decode(k4a_image_t image, ColorImage& into) {
    const auto* bytes = reinterpret_cast<const char*>(k4a_image_get_buffer(image));
    const Intrinsics& K = camera_.color->intrinsics;
    try {
      decodeJpeg(name() + ": a colour image", std::string(bytes, k4a_image_get_size(image)), into,
                 [&](int width, int height) {
                   if (width != K.width || height != K.height) throw InputError("is of another size");
                 });
    } catch (const InputError&) {
      into.resize(0, 0);
      if (!std::exchange(said_damaged_, true))
        notice_ = name() + ": a colour image is damaged; views of such are used without colour";
    }
  }

  K4aHandle handle_;
  Camera camera_;
  std::vector<std::string> warnings_;
  k4a_wired_sync_mode_t mode_{K4A_WIRED_SYNC_MODE_STANDALONE};
  unsigned delay_{0};  ///< µs after the master
  std::unique_ptr<K4aNotStarted> not_started_;
  bool started_{false};
  bool said_damaged_{false};
  std::string notice_;
};

std::unique_ptr<CameraSource> openK4a(const std::string& id) {
  const std::string name = "k4a:" + id;
  const std::optional<unsigned> index = id.empty() ? 0u : deviceIndex(id);
  K4aHandle handle;
  if (index) {
    const std::lock_guard<std::mutex> lock(k4aMutex());
    if (*index < k4aCount()) {
      handle = openK4aHandle(*index);
      if (!handle) throw InputError(nameInMessages(name) + ": cannot be opened; " + kK4aCannotOpen);
    }
  } else {
    handle = openK4aSerial(id);
  }
  if (!handle) failNotConnected(name, k4aKind(), k4aList());
  const std::string serial = k4aSerial(handle.get());
  if (serial.empty()) throw InputError(nameInMessages(name) + ": its serial number cannot be read from the device");
  return std::make_unique<DeviceSource>(std::make_unique<K4aDevice>(std::move(handle), serial),
                                        [serial]() -> std::unique_ptr<Device> {
                                          K4aHandle again = openK4aSerial(serial);
                                          if (!again) return nullptr;
                                          return std::make_unique<K4aDevice>(std::move(again), serial);
                                        });
}

}  // namespace

DeviceKind k4aKind() { return {"k4a", "Azure Kinect", "", openK4a, k4aList}; }

}  // namespace fuse_flow::io

#else

namespace fuse_flow::io {

DeviceKind k4aKind() {
  return {"k4a", "Azure Kinect", "libk4a; install Microsoft's libk4a1.4-dev, or Orbbec's K4A wrapper for Femto"};
}

}  // namespace fuse_flow::io

#endif
