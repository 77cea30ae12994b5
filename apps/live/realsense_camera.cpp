#include "live/device_kinds.h"

#ifdef FUSE_FLOW_WITH_REALSENSE2

#include "live/device_conversions.h"
#include "live/device_source.h"
#include "recordings/calibrations/lens_models.h"

#include <librealsense2/rs.hpp>

#include <cmath>
#include <stdexcept>
#include <utility>

namespace fuse_flow::io {
namespace {

constexpr int kRealSenseWidth = 640, kRealSenseHeight = 480, kRealSenseRate = 30;  // pixels, Hz; all models have it

/** \brief One for the process: it follows what is plugged in. */
rs2::context& realSenseContext() {
  static rs2::context context;
  return context;
}

/** \brief Runs what uses the library, whose exceptions become InputError. */
template <typename Action>
auto askRealSense(const std::string& name, const std::string& failed, const Action& action) {
  try {
    return action();
  } catch (const InputError&) {
    throw;
  } catch (const std::runtime_error& error) {  // rs2::error, and what its headers throw
    std::string what = error.what();
    for (char& c : what)
      if (c == '\n') c = ' ';
    throw InputError(name + ": " + failed + " (librealsense2: " + what + ")");
  }
}

std::string realSenseInfo(const rs2::device& device, rs2_camera_info info) {
  return device.supports(info) ? device.get_info(info) : "";
}

std::vector<ConnectedDevice> realSenseList() {
  return askRealSense("realsense", "cannot tell which cameras are connected", [] {
    std::vector<ConnectedDevice> list;
    const rs2::device_list devices = realSenseContext().query_devices();
    for (std::uint32_t i = 0; i < devices.size(); ++i) {
      const rs2::device device = devices[i];
      const std::string serial = realSenseInfo(device, RS2_CAMERA_INFO_SERIAL_NUMBER);
      if (!serial.empty()) list.push_back({"realsense:" + serial, realSenseInfo(device, RS2_CAMERA_INFO_NAME)});
    }
    return list;
  });
}

bool isRealSenseConnected(const std::string& name) {
  for (const ConnectedDevice& device : realSenseList())
    if (device.name == name) return true;
  return false;
}

Intrinsics realSenseLens(const std::string& owner, const rs2_intrinsics& lens, std::vector<std::string>& warnings) {
  const Intrinsics K{lens.width, lens.height, lens.fx, lens.fy, lens.ppx, lens.ppy, {}};
  return withDistortion(owner, K, rs2_distortion_to_string(lens.model),
                        {lens.coeffs[0], lens.coeffs[1], lens.coeffs[2], lens.coeffs[3], lens.coeffs[4]}, warnings);
}

class RealSenseDevice : public Device {
 public:
  explicit RealSenseDevice(const std::string& serial) : Device("realsense:" + serial), pipeline_(realSenseContext()) {
    camera_.name = cameraNameOf(name());
    askRealSense(name(), cannotDeliver(), [&] {
      has_color_ = deliversColor(serial);
      config_.enable_device(serial);
      config_.enable_stream(RS2_STREAM_DEPTH, kRealSenseWidth, kRealSenseHeight, RS2_FORMAT_Z16, kRealSenseRate);
      if (has_color_)
        config_.enable_stream(RS2_STREAM_COLOR, kRealSenseWidth, kRealSenseHeight, RS2_FORMAT_RGB8, kRealSenseRate);
      describe(config_.resolve(pipeline_));
    });
    checkCamera(camera_);
  }
  ~RealSenseDevice() override {
    try {
      if (started_) pipeline_.stop();
    } catch (const rs2::error&) {  // it is unplugged
    }
  }

  const Camera& camera() const override { return camera_; }
  bool hasColor() const override { return has_color_; }
  std::vector<std::string> warnings() const override { return warnings_; }

  void start() override {
    askRealSense(name(), cannotDeliver(), [&] {
      const rs2::pipeline_profile profile = pipeline_.start(config_);
      started_ = true;
      stampByDevice(profile.get_device());
    });
  }

  /** \brief Asks again and again: the pipeline's own wait() starts an unplugged camera again by itself, for seconds, and where stop() cannot end it. */
  std::optional<DeviceImages> wait(std::chrono::milliseconds longest) override {
    return askRealSense(name(), "was unplugged, or failed", [&]() -> std::optional<DeviceImages> {
      const auto end = std::chrono::steady_clock::now() + longest;
      rs2::frameset frames;
      while (!pipeline_.poll_for_frames(&frames)) {
        if (std::chrono::steady_clock::now() >= end) return {};
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
      return imagesOf(frames);
    });
  }

  bool connected() override { return isRealSenseConnected(name()); }
  std::string notice() override { return std::exchange(notice_, {}); }

 private:
  static std::string cannotDeliver() {
    return "cannot deliver images of " + std::to_string(kRealSenseWidth) + "x" + std::to_string(kRealSenseHeight) +
           " at " + std::to_string(kRealSenseRate) + " Hz; it needs USB 3, and no other program may use it";
  }

  static bool deliversColor(const std::string& serial) {
    const rs2::device_list devices = realSenseContext().query_devices();
    for (std::uint32_t i = 0; i < devices.size(); ++i) {
      const rs2::device device = devices[i];
      if (realSenseInfo(device, RS2_CAMERA_INFO_SERIAL_NUMBER) != serial) continue;
      for (const rs2::sensor& sensor : device.query_sensors())
        for (const rs2::stream_profile& profile : sensor.get_stream_profiles())
          if (profile.stream_type() == RS2_STREAM_COLOR) return true;
    }
    return false;
  }

  void describe(const rs2::pipeline_profile& profile) {
    const auto depth = profile.get_stream(RS2_STREAM_DEPTH).as<rs2::video_stream_profile>();
    camera_.depth_scale = profile.get_device().first<rs2::depth_sensor>().get_depth_scale();
    camera_.intrinsics = realSenseLens(name() + ": depth", depth.get_intrinsics(), warnings_);
    if (!has_color_) return;
    const auto color = profile.get_stream(RS2_STREAM_COLOR).as<rs2::video_stream_profile>();
    const rs2_extrinsics T_depth_color = color.get_extrinsics_to(depth);
    ColorCamera own;
    own.intrinsics = realSenseLens(name() + ": colour", color.get_intrinsics(), warnings_);
    own.T_depth_color = columnMajorPose(T_depth_color.rotation, T_depth_color.translation);
    camera_.color = own;
  }

  /** \brief Newer libraries estimate the host's time of each image, and begin with the device's until they can: stamps would jump. ViewSynchronizer
   *  estimates by itself. */
  static void stampByDevice(const rs2::device& device) {
#if RS2_API_VERSION >= 23000
    for (const rs2::sensor& sensor : device.query_sensors())
      if (sensor.supports(RS2_OPTION_GLOBAL_TIME_ENABLED)) sensor.set_option(RS2_OPTION_GLOBAL_TIME_ENABLED, 0);
#else
    (void)device;
#endif
  }

  std::optional<DeviceImages> imagesOf(const rs2::frameset& frames) {
    const rs2::video_frame depth = frames.get_depth_frame(), color = frames.get_color_frame();
    if (!depth) return {};
    const auto images = std::make_shared<LoadedView>();
    copyFrame(depth, camera_.intrinsics, images->depth16);
    if (color && has_color_ && together(depth, color)) copyFrame(color, camera_.color->intrinsics, images->color);
    return DeviceImages{stampOf(depth), images};
  }

  /** \brief Where colour is missing, the pipeline repeats the last. */
  static bool together(const rs2::frame& depth, const rs2::frame& color) {
    constexpr double longest = 1.5 * 1000 / kRealSenseRate;  // ms
    return depth.get_frame_timestamp_domain() != color.get_frame_timestamp_domain() ||
           std::abs(depth.get_timestamp() - color.get_timestamp()) <= longest;
  }

  template <typename Pixel>
  void copyFrame(const rs2::video_frame& frame, const Intrinsics& K, Image<Pixel>& into) const {
    if (frame.get_width() != K.width || frame.get_height() != K.height ||
        frame.get_bytes_per_pixel() != static_cast<int>(sizeof(Pixel)))
      throw InputError(name() + ": delivers images of another size or format than was asked for");
    copyRows(frame.get_data(), static_cast<std::size_t>(frame.get_stride_in_bytes()), K.width, K.height, into);
  }

  std::uint64_t stampOf(const rs2::frame& frame) {
    const auto us = static_cast<std::uint64_t>(std::llround(frame.get_timestamp() * 1000));
    if (frame.get_frame_timestamp_domain() == RS2_TIMESTAMP_DOMAIN_HARDWARE_CLOCK) return unwrapped_(us);
    if (frame.get_frame_timestamp_domain() == RS2_TIMESTAMP_DOMAIN_SYSTEM_TIME && !std::exchange(said_arrival_, true))
      notice_ = name() +
                ": has no time stamps of its own, since the kernel does not deliver the camera's metadata; the times "
                "of arrival are used, which are less exact";
    return us;
  }

  rs2::pipeline pipeline_;
  rs2::config config_;
  Camera camera_;
  bool has_color_{false};
  bool started_{false};
  bool said_arrival_{false};
  std::vector<std::string> warnings_;
  std::string notice_;
  UnwrappedStamp unwrapped_;
};

std::unique_ptr<CameraSource> openRealSense(const std::string& id) {
  const std::vector<ConnectedDevice> connected = realSenseList();
  std::string name = "realsense:" + id;
  if (id.empty() && !connected.empty()) name = connected[0].name;
  if (!isRealSenseConnected(name)) failNotConnected(name, realSenseKind(), connected);
  const std::string serial = name.substr(name.find(':') + 1);
  return std::make_unique<DeviceSource>(std::make_unique<RealSenseDevice>(serial),
                                        [name, serial]() -> std::unique_ptr<Device> {
                                          if (!isRealSenseConnected(name)) return nullptr;
                                          return std::make_unique<RealSenseDevice>(serial);
                                        });
}

}  // namespace

DeviceKind realSenseKind() { return {"realsense", "RealSense camera", "", openRealSense, realSenseList}; }

}  // namespace fuse_flow::io

#else

namespace fuse_flow::io {

DeviceKind realSenseKind() {
  return {"realsense", "RealSense camera", "librealsense2; install librealsense2-dev of Intel's or of ROS's packages"};
}

}  // namespace fuse_flow::io

#endif
