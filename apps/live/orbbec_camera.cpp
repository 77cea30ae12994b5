#include "live/device_kinds.h"

#ifdef FUSE_FLOW_WITH_ORBBEC

#include "live/device_conversions.h"
#include "live/device_source.h"
#include "recordings/calibrations/lens_models.h"
#include "recordings/images/jpeg_decode.h"
#include "recordings/messages/image_messages.h"

#include <libobsensor/ObSensor.h>
#include <libobsensor/h/MultipleDevices.h>

#include <dlfcn.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <type_traits>
#include <utility>

namespace fs = std::filesystem;

namespace fuse_flow::io {
namespace {

/** \brief The last argument of the SDK's functions: what failed, if one did. */
class OrbbecError {
 public:
  OrbbecError() = default;
  ~OrbbecError() { release(ob_delete_error); }
  OrbbecError(const OrbbecError&) = delete;
  OrbbecError& operator=(const OrbbecError&) = delete;

  ob_error** out() { return &error_; }
  explicit operator bool() const { return error_ != nullptr; }
  /** \brief In one line. */
  std::string message() const {
    const char* text = ob_error_get_message(error_);
    std::string line = text ? text : "";
    for (char& c : line)
      if (c == '\n' || c == '\r') c = ' ';
    return line;
  }

 private:
  /** \brief Versions of the SDK differ in whether it takes the error or where it is. */
  template <typename Delete>
  void release(Delete* function) {
    if (!error_) return;
    if constexpr (std::is_invocable_v<Delete*, ob_error**>)
      function(&error_);
    else
      function(error_);
  }

  ob_error* error_{nullptr};
};

template <typename Function, typename... Arguments>
using OrbbecResult = std::invoke_result_t<Function*, Arguments..., ob_error**>;

/** \brief Calls a function of the SDK, whose failure becomes InputError. \param failed how that begins: "orbbec:CL8M: cannot be started" */
template <typename Function, typename... Arguments>
OrbbecResult<Function, Arguments...> askOrbbec(const std::string& failed, Function* function, Arguments... arguments) {
  OrbbecError error;
  const auto check = [&] {
    if (error) throw InputError(failed + " (OrbbecSDK: " + error.message() + ")");
  };
  if constexpr (std::is_void_v<OrbbecResult<Function, Arguments...>>) {
    function(arguments..., error.out());
    check();
  } else {
    const auto result = function(arguments..., error.out());
    check();
    return result;
  }
}

/** \brief Its failure is nothing that anyone could do something about. */
template <auto release>
struct OrbbecRelease {
  template <typename Handle>
  void operator()(Handle* handle) const {
    OrbbecError error;
    release(handle, error.out());
  }
};
template <typename Handle, auto release>
using OrbbecOwned = std::unique_ptr<Handle, OrbbecRelease<release>>;
using OrbbecContext = OrbbecOwned<ob_context, ob_delete_context>;
using OrbbecList = OrbbecOwned<ob_device_list, ob_delete_device_list>;
using OrbbecHandle = OrbbecOwned<ob_device, ob_delete_device>;
using OrbbecSensors = OrbbecOwned<ob_sensor_list, ob_delete_sensor_list>;
using OrbbecPipeline = OrbbecOwned<ob_pipeline, ob_delete_pipeline>;
using OrbbecConfig = OrbbecOwned<ob_config, ob_delete_config>;
using OrbbecProfiles = OrbbecOwned<const ob_stream_profile_list, ob_delete_stream_profile_list>;
using OrbbecProfile = OrbbecOwned<ob_stream_profile, ob_delete_stream_profile>;
using OrbbecFrame = OrbbecOwned<const ob_frame, ob_delete_frame>;

/** \brief Filters and Femto's depth engine are libraries in a folder beside the SDK's own, which looks for them where the program was started. */
void findOrbbecExtensions() {
  Dl_info library{};
  void* const symbol = dlsym(RTLD_DEFAULT, "ob_create_context");
  if (!symbol || dladdr(symbol, &library) == 0 || !library.dli_fname) return;
  const fs::path folder = fs::path(library.dli_fname).parent_path() / "extensions";
  std::error_code none;
  if (!fs::is_directory(folder, none)) return;
  OrbbecError ignored;
  ob_set_extensions_directory(folder.c_str(), ignored.out());
}

/** \brief One for the process: it follows what is plugged in. */
ob_context* orbbecContext() {
  static const OrbbecContext context = [] {
    OrbbecError ignored;  // else it logs to standard output, and into a folder where the program was started
    ob_set_logger_severity(OB_LOG_SEVERITY_OFF, ignored.out());
    findOrbbecExtensions();
    return OrbbecContext(askOrbbec("orbbec: cannot be used", ob_create_context));
  }();
  return context.get();
}

constexpr const char* kOrbbecCannotOpen =
    "it is in use, or its user may not use USB devices, which the rules of OrbbecSDK for udev allow";
constexpr const char* kOrbbecCannotList = "orbbec: cannot tell which cameras are connected";

OrbbecList orbbecDevices() { return OrbbecList(askOrbbec(kOrbbecCannotList, ob_query_device_list, orbbecContext())); }

std::string orbbecText(const char* text) { return text ? text : ""; }

/** \brief In the order of their numbers; empty where it cannot be read. */
std::vector<std::string> orbbecSerials(const ob_device_list* devices) {
  std::vector<std::string> serials(askOrbbec(kOrbbecCannotList, ob_device_list_get_count, devices));
  for (std::uint32_t i = 0; i < serials.size(); ++i)
    serials[i] = orbbecText(askOrbbec(kOrbbecCannotList, ob_device_list_get_device_serial_number, devices, i));
  return serials;
}

std::vector<ConnectedDevice> orbbecList() {
  const OrbbecList devices = orbbecDevices();
  const std::vector<std::string> serials = orbbecSerials(devices.get());
  std::vector<ConnectedDevice> list;
  for (std::uint32_t i = 0; i < serials.size(); ++i) {
    const std::string number = "orbbec:#" + std::to_string(i + 1);
    const std::string model = orbbecText(askOrbbec(kOrbbecCannotList, ob_device_list_get_device_name,
                                                   static_cast<const ob_device_list*>(devices.get()), i));
    if (serials[i].empty())
      list.push_back({number, model + "; " + kOrbbecCannotOpen});
    else
      list.push_back({"orbbec:" + serials[i], model + ", " + number});
  }
  return list;
}

bool isOrbbecConnected(const std::string& serial) {
  const std::vector<std::string> serials = orbbecSerials(orbbecDevices().get());
  return std::find(serials.begin(), serials.end(), serial) != serials.end();
}

/** \brief Millimetres. */
float orbbecUnit(int precision_level) {
  switch (precision_level) {
    case OB_PRECISION_0MM8:
      return 0.8f;
    case OB_PRECISION_0MM4:
      return 0.4f;
    case OB_PRECISION_0MM1:
      return 0.1f;
    case OB_PRECISION_0MM2:
      return 0.2f;
    case OB_PRECISION_0MM5:
      return 0.5f;
    case OB_PRECISION_0MM05:
      return 0.05f;
    default:
      return 1.0f;
  }
}

Intrinsics orbbecLens(const std::string& owner, const Intrinsics& K, const ob_camera_distortion& d,
                      std::vector<std::string>& warnings) {
  switch (d.model) {
    case OB_DISTORTION_NONE:
      return K;
    case OB_DISTORTION_MODIFIED_BROWN_CONRADY:
      return withDistortion(owner, K, "modified_brown_conrady", {d.k1, d.k2, d.p1, d.p2, d.k3}, warnings);
    case OB_DISTORTION_INVERSE_BROWN_CONRADY:
      return withDistortion(owner, K, "inverse_brown_conrady", {d.k1, d.k2, d.p1, d.p2, d.k3}, warnings);
    case OB_DISTORTION_BROWN_CONRADY:
      return withDistortion(owner, K, "brown_conrady", {d.k1, d.k2, d.p1, d.p2, d.k3}, warnings);
    case OB_DISTORTION_BROWN_CONRADY_K6:
      return withDistortion(owner, K, "rational_polynomial", {d.k1, d.k2, d.p1, d.p2, d.k3, d.k4, d.k5, d.k6},
                            warnings);
    case OB_DISTORTION_KANNALA_BRANDT4:
      return withDistortion(owner, K, "kannala_brandt", {d.k1, d.k2, d.k3, d.k4}, warnings);
  }
  throw InputError(owner + ": has a model of distortion that is not known here, number " +
                   std::to_string(static_cast<int>(d.model)));
}

/** \brief As messages call the pixels of colour images. Empty: cannot be used, or is JPEG. */
std::string orbbecEncoding(ob_format format) {
  switch (format) {
    case OB_FORMAT_RGB:
      return "rgb8";
    case OB_FORMAT_BGR:
      return "bgr8";
    case OB_FORMAT_YUYV:
    case OB_FORMAT_YUY2:
      return "yuyv";
    case OB_FORMAT_UYVY:
      return "uyvy";
    default:
      return {};
  }
}

class OrbbecDevice : public Device {
 public:
  explicit OrbbecDevice(const std::string& serial) : Device("orbbec:" + serial), serial_(serial) {
    camera_.name = cameraNameOf(name());
    const OrbbecList devices = orbbecDevices();
    handle_.reset(ask(std::string("cannot be opened; ") + kOrbbecCannotOpen, ob_device_list_get_device_by_serial_number,
                      static_cast<const ob_device_list*>(devices.get()), serial.c_str()));
    pipeline_.reset(ask("cannot be used", ob_create_pipeline_with_device, device()));
    config_.reset(ask("cannot be used", ob_create_config));
    describe();
    checkCamera(camera_);
  }
  ~OrbbecDevice() override {
    OrbbecError ignored;  // it may be unplugged
    if (started_) ob_pipeline_stop(pipeline_.get(), ignored.out());
  }

  const Camera& camera() const override { return camera_; }
  bool hasColor() const override { return camera_.color.has_value(); }
  std::vector<std::string> warnings() const override { return warnings_; }

  void start() override {
    {
      OrbbecError ignored;  // of models that cannot: then together() decides
      ob_pipeline_enable_frame_sync(pipeline_.get(), ignored.out());
    }
    ask("cannot be started; it needs USB 3, and no other program may use it", ob_pipeline_start_with_config,
        pipeline_.get(), static_cast<const ob_config*>(config_.get()));
    started_ = true;
  }

  std::optional<DeviceImages> wait(std::chrono::milliseconds longest) override {
    const OrbbecFrame frames(
        askFrame(ob_pipeline_wait_for_frameset, pipeline_.get(), static_cast<std::uint32_t>(longest.count())));
    if (!frames) return {};
    const OrbbecFrame depth(askFrame(ob_frameset_get_depth_frame, frames.get()));
    // Depth and colour of an instant may come in a set each.
    OrbbecFrame color(askFrame(ob_frameset_get_color_frame, frames.get()));
    if (color && hasColor()) color_ = std::move(color);
    if (!depth) return {};
    const auto images = std::make_shared<LoadedView>();
    copyDepth(depth.get(), images->depth16);
    const bool colored = color_ && together(depth.get(), color_.get());
    if (colored) decode(color_.get(), images->color);
    lookAtColors(colored);
    return DeviceImages{stampOf(depth.get()), images};
  }

  bool connected() override { return isOrbbecConnected(serial_); }
  std::string waitsFor() const override { return waits_for_; }
  std::string notice() override { return std::exchange(notice_, {}); }

 private:
  template <typename Function, typename... Arguments>
  OrbbecResult<Function, Arguments...> ask(const std::string& failed, Function* function,
                                           Arguments... arguments) const {
    return askOrbbec(name() + ": " + failed, function, arguments...);
  }
  template <typename Function, typename... Arguments>
  OrbbecResult<Function, Arguments...> askFrame(Function* function, Arguments... arguments) const {
    return ask("was unplugged, or failed", function, arguments...);
  }
  const ob_device* device() const { return handle_.get(); }

  /** \brief The streams that the camera delivers unless told otherwise; depth as it measures it, not registered to colour. */
  void describe() {
    const OrbbecProfiles depths = profilesOf(OB_SENSOR_DEPTH);
    const OrbbecProfile depth = profileOf(depths.get(), OB_WIDTH_ANY, OB_HEIGHT_ANY, OB_FORMAT_Y16, OB_FPS_ANY);
    if (!depth) throw InputError(name() + ": has no depth of 16 bits (Y16)");
    period_us_ = 1e6 / std::max(1u, askStream(ob_video_stream_profile_get_fps, stream(depth)));
    enable(depth);
    camera_.intrinsics = lensOf(": depth", depth);
    unit_ = unit();
    camera_.depth_scale = 0.001f * unit_;
    readSyncMode();
    if (!deliversColor()) return;
    const OrbbecProfiles colors = profilesOf(OB_SENSOR_COLOR);
    const OrbbecProfile color = colorProfile(colors.get(), depth);
    if (!color) {
      warnings_.push_back(name() + ": its colour is not used: it must be RGB, BGR, MJPG, YUYV or UYVY");
      return;
    }
    enable(color);
    ColorCamera own;
    own.intrinsics = lensOf(": colour", color);
    const ob_extrinsic to_depth = askStream(ob_stream_profile_get_extrinsic_to, stream(color), depth.get());
    float rotation[9], translation[3];  // its members are packed
    std::copy(std::begin(to_depth.rot), std::end(to_depth.rot), rotation);
    std::copy(std::begin(to_depth.trans), std::end(to_depth.trans), translation);
    own.T_depth_color = rowMajorPose(rotation, translation);
    camera_.color = own;
  }

  static const ob_stream_profile* stream(const OrbbecProfile& profile) { return profile.get(); }
  template <typename Function, typename... Arguments>
  OrbbecResult<Function, Arguments...> askStream(Function* function, Arguments... arguments) const {
    return ask("does not tell its streams or its calibration", function, arguments...);
  }

  OrbbecProfiles profilesOf(ob_sensor_type sensor) const {
    return OrbbecProfiles(
        askStream(ob_pipeline_get_stream_profile_list, static_cast<const ob_pipeline*>(pipeline_.get()), sensor));
  }
  /** \brief Null if there is none. */
  static OrbbecProfile profileOf(const ob_stream_profile_list* profiles, int width, int height, ob_format format,
                                 int rate) {
    OrbbecError none;
    return OrbbecProfile(
        ob_stream_profile_list_get_video_stream_profile(profiles, width, height, format, rate, none.out()));
  }
  void enable(const OrbbecProfile& profile) const {
    askStream(ob_config_enable_stream_with_stream_profile, config_.get(), stream(profile));
  }

  bool deliversColor() const {
    const OrbbecSensors sensors(askStream(ob_device_get_sensor_list, device()));
    const ob_sensor_list* list = sensors.get();
    const std::uint32_t count = askStream(ob_sensor_list_get_count, list);
    for (std::uint32_t i = 0; i < count; ++i)
      if (askStream(ob_sensor_list_get_sensor_type, list, i) == OB_SENSOR_COLOR) return true;
    return false;
  }

  /** \brief Of the usual size, at the rate of depth if there is such, in a format that is used here. */
  OrbbecProfile colorProfile(const ob_stream_profile_list* profiles, const OrbbecProfile& depth) const {
    const OrbbecProfile usual(askStream(ob_stream_profile_list_get_profile, profiles, OB_PROFILE_DEFAULT));
    const int width = static_cast<int>(askStream(ob_video_stream_profile_get_width, stream(usual)));
    const int height = static_cast<int>(askStream(ob_video_stream_profile_get_height, stream(usual)));
    const int rate = static_cast<int>(askStream(ob_video_stream_profile_get_fps, stream(depth)));
    for (const int hertz : {rate, OB_FPS_ANY})
      for (const ob_format format : {OB_FORMAT_RGB, OB_FORMAT_BGR, OB_FORMAT_MJPG, OB_FORMAT_YUYV, OB_FORMAT_UYVY})
        if (OrbbecProfile found = profileOf(profiles, width, height, format, hertz)) return found;
    return nullptr;
  }

  Intrinsics lensOf(const std::string& which, const OrbbecProfile& profile) {
    const ob_camera_intrinsic lens = askStream(ob_video_stream_profile_get_intrinsic, stream(profile));
    const auto width = static_cast<int>(askStream(ob_video_stream_profile_get_width, stream(profile)));
    const auto height = static_cast<int>(askStream(ob_video_stream_profile_get_height, stream(profile)));
    if (lens.width != width || lens.height != height)
      throw InputError(name() + which + ": its images are of " + std::to_string(width) + "x" + std::to_string(height) +
                       " pixels, its intrinsics for " + std::to_string(lens.width) + "x" + std::to_string(lens.height));
    const Intrinsics K{width, height, lens.fx, lens.fy, lens.cx, lens.cy, {}};
    return orbbecLens(name() + which, K, askStream(ob_video_stream_profile_get_distortion, stream(profile)), warnings_);
  }

  bool supports(ob_property_id property) const {
    OrbbecError error;
    return ob_device_is_property_supported(device(), property, OB_PERMISSION_READ, error.out()) && !error;
  }
  /** \brief Millimetres that a depth of 1 means. Each image says it, too, but none came yet. */
  float unit() const {
    if (supports(OB_PROP_DEPTH_UNIT_FLEXIBLE_ADJUSTMENT_FLOAT)) {
      const float unit =
          askStream(ob_device_get_float_property, handle_.get(), OB_PROP_DEPTH_UNIT_FLEXIBLE_ADJUSTMENT_FLOAT);
      if (std::isfinite(unit) && unit > 0) return unit;
    }
    if (supports(OB_PROP_DEPTH_PRECISION_LEVEL_INT))
      return orbbecUnit(askStream(ob_device_get_int_property, handle_.get(), OB_PROP_DEPTH_PRECISION_LEVEL_INT));
    return 1.0f;
  }

  /** \brief The mode stays as it is; some deliver nothing before another device or program says so. */
  void readSyncMode() {
    OrbbecError error;
    const ob_multi_device_sync_config sync = ob_device_get_multi_device_sync_config(device(), error.out());
    if (error) return;  // a model that has none
    if (sync.syncMode == OB_MULTI_DEVICE_SYNC_MODE_SECONDARY ||
        sync.syncMode == OB_MULTI_DEVICE_SYNC_MODE_HARDWARE_TRIGGERING)
      waits_for_ = "its synchronisation mode waits for a trigger; start its primary, or set it to standalone";
    if (sync.syncMode == OB_MULTI_DEVICE_SYNC_MODE_SOFTWARE_TRIGGERING)
      waits_for_ = "its synchronisation mode waits for a program that triggers it; set it to standalone";
  }

  /** \brief Says once that many views have none. */
  void lookAtColors(bool colored) {
    if (!hasColor() || said_colors_) return;
    ++views_;
    if (!colored) ++without_color_;
    constexpr int enough = 90;  // views, some seconds
    if (views_ < enough || without_color_ * 4 < views_) return;
    notice_ = name() + ": " + std::to_string(without_color_) + " of " + std::to_string(views_) +
              " views had no colour image of their time; its depth and colour should have the same rate";
    said_colors_ = true;
  }

  /** \brief Where colour is missing, a set may have an older one. */
  bool together(const ob_frame* depth, const ob_frame* color) const {
    const auto a = static_cast<double>(askFrame(ob_frame_get_timestamp_us, depth));
    const auto b = static_cast<double>(askFrame(ob_frame_get_timestamp_us, color));
    return std::abs(a - b) <= 1.5 * period_us_;
  }

  /** \brief Its bytes. Throws unless it has at least so many. */
  const std::uint8_t* bytesOf(const ob_frame* frame, std::size_t least) const {
    const std::uint8_t* bytes = askFrame(ob_frame_get_data, frame);
    if (!bytes || askFrame(ob_frame_get_data_size, frame) < least)
      throw InputError(name() + ": delivers an image that is cut short");
    return bytes;
  }

  bool isOfSize(const ob_frame* frame, const Intrinsics& K) const {
    return askFrame(ob_video_frame_get_width, frame) == static_cast<std::uint32_t>(K.width) &&
           askFrame(ob_video_frame_get_height, frame) == static_cast<std::uint32_t>(K.height);
  }

  void copyDepth(const ob_frame* frame, DepthImage& into) const {
    const Intrinsics& K = camera_.intrinsics;
    const ob_format format = askFrame(ob_frame_get_format, frame);
    const ob_pixel_type type = askFrame(ob_video_frame_get_pixel_type, frame);
    if (!isOfSize(frame, K) || (format != OB_FORMAT_Y16 && format != OB_FORMAT_Z16) || type == OB_PIXEL_DISPARITY ||
        type == OB_PIXEL_RAW_PHASE)
      throw InputError(name() + ": delivers depth of another size or format than was asked for");
    const std::size_t row = static_cast<std::size_t>(K.width) * sizeof(std::uint16_t);
    copyRows(bytesOf(frame, row * static_cast<std::size_t>(K.height)), row, K.width, K.height, into);
    const float unit = askFrame(ob_depth_frame_get_value_scale, frame);
    if (!std::isfinite(unit) || unit <= 0) throw InputError(name() + ": does not tell the unit of its depth");
    constexpr float same = 1e-4f;
    if (std::abs(unit - unit_) > same * unit_) rescaleDepth(into, unit / unit_);
  }

  /** \brief USB damages an image now and then: its view then has no colour. */
  void decode(const ob_frame* frame, ColorImage& into) {
    const Intrinsics& K = camera_.color->intrinsics;
    const std::string what = name() + ": a colour image";
    try {
      if (!isOfSize(frame, K)) throw InputError("is of another size");
      const ob_format format = askFrame(ob_frame_get_format, frame);
      const auto* bytes = reinterpret_cast<const char*>(bytesOf(frame, 1));
      const std::size_t size = askFrame(ob_frame_get_data_size, frame);
      const auto check = [&](int width, int height) {
        if (width != K.width || height != K.height) throw InputError("is of another size");
      };
      if (format == OB_FORMAT_MJPG) {
        decodeJpeg(what, std::string(bytes, size), into, check);
        return;
      }
      ImageMessage image;
      image.encoding = orbbecEncoding(format);
      image.width = static_cast<std::uint32_t>(K.width);
      image.height = static_cast<std::uint32_t>(K.height);
      image.step = image.width * (format == OB_FORMAT_RGB || format == OB_FORMAT_BGR ? 3 : 2);
      image.data = {bytes, size};
      decodeColor(what, image, into, check);
    } catch (const InputError&) {
      into.resize(0, 0);
      if (!std::exchange(said_damaged_, true))
        notice_ = name() + ": a colour image is damaged; views of such are used without colour";
    }
  }

  /** \brief Of the device's clock. The SDK can estimate the host's time of each image, too, but corrects its estimate again and again, and stamps would
   *  jump; ViewSynchronizer estimates by itself. */
  std::uint64_t stampOf(const ob_frame* frame) {
    const std::uint64_t stamp = askFrame(ob_frame_get_timestamp_us, frame);
    if (stamp == 0 && !std::exchange(by_arrival_, true))
      notice_ = name() + ": has no time stamps of its own; the times of arrival are used, which are less exact";
    return by_arrival_ ? askFrame(ob_frame_get_system_timestamp_us, frame) : unwrapped_(stamp);
  }

  std::string serial_;
  OrbbecHandle handle_;
  OrbbecPipeline pipeline_;
  OrbbecConfig config_;
  Camera camera_;
  float unit_{1};        ///< millimetres that a depth of 1 means
  double period_us_{0};  ///< from one depth image to the next
  std::string waits_for_;
  bool started_{false};
  bool said_damaged_{false};
  bool by_arrival_{false};
  std::vector<std::string> warnings_;
  std::string notice_;
  OrbbecFrame color_;  ///< the last one
  int views_{0}, without_color_{0};
  bool said_colors_{false};
  UnwrappedStamp unwrapped_;
};

/** \brief The serial number of orbbec:id among the connected. */
std::string orbbecSerial(const std::string& id) {
  const std::string name = "orbbec:" + id;
  const std::vector<std::string> serials = orbbecSerials(orbbecDevices().get());
  std::optional<unsigned> number;
  if (id.empty()) number = 1;
  if (!id.empty() && id[0] == '#') {
    number = deviceIndex(id.substr(1));
    if (!number || *number == 0) throw InputError(name + ": must be orbbec:#1, orbbec:#2, …, or orbbec:SERIAL");
  }
  if (number && *number <= serials.size()) {
    const std::string& serial = serials[*number - 1];
    if (serial.empty()) throw InputError(nameInMessages(name) + ": cannot be opened; " + kOrbbecCannotOpen);
    return serial;
  }
  if (!number && std::find(serials.begin(), serials.end(), id) != serials.end()) return id;
  failNotConnected(name, orbbecKind(), orbbecList());
}

std::unique_ptr<CameraSource> openOrbbec(const std::string& id) {
  const std::string serial = orbbecSerial(id);
  return std::make_unique<DeviceSource>(std::make_unique<OrbbecDevice>(serial), [serial]() -> std::unique_ptr<Device> {
    if (!isOrbbecConnected(serial)) return nullptr;
    return std::make_unique<OrbbecDevice>(serial);
  });
}

}  // namespace

DeviceKind orbbecKind() { return {"orbbec", "Orbbec camera", "", openOrbbec, orbbecList}; }

}  // namespace fuse_flow::io

#else

namespace fuse_flow::io {

DeviceKind orbbecKind() {
  return {"orbbec", "Orbbec camera",
          "OrbbecSDK; install version 2 of Orbbec's OrbbecSDK (without it, Femto are k4a: with Orbbec's K4A wrapper, "
          "and Astra openni2:)"};
}

}  // namespace fuse_flow::io

#endif
