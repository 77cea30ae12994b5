#include "live/device_kinds.h"

#include <pcl/pcl_config.h>

#ifdef HAVE_OPENNI2

#include "clouds/grabber.h"
#include "live/device_conversions.h"
#include "live/device_source.h"

#include <pcl/io/openni2/openni2_device_manager.h>
#include <pcl/io/openni2_grabber.h>

#include <algorithm>
#include <iterator>
#include <utility>

namespace fuse_flow::io {
namespace {

using Openni2Info = pcl::io::openni2::OpenNI2DeviceInfo;

/** \brief What is connected, in the order of the numbers #1, #2, … */
std::vector<Openni2Info> openni2Infos() {
  static const auto manager = []() -> decltype(pcl::io::openni2::OpenNI2DeviceManager::getInstance()) {
    try {
      return pcl::io::openni2::OpenNI2DeviceManager::getInstance();
    } catch (const std::exception&) {  // once only: the next time, it would succeed, and find no device
      return nullptr;
    }
  }();
  if (!manager)
    throw InputError("openni2: OpenNI 2 finds none of its drivers, must be installed with its folder OpenNI2/Drivers");
  return *manager->getConnectedDeviceInfos();
}

std::vector<ConnectedDevice> openni2List() {
  std::vector<ConnectedDevice> list;
  for (const Openni2Info& info : openni2Infos())
    list.push_back({"openni2:#" + std::to_string(list.size() + 1), info.vendor_ + " " + info.name_ + ", " + info.uri_});
  return list;
}

bool isOpenni2(const std::vector<Openni2Info>& infos, const std::string& uri) {
  return std::any_of(infos.begin(), infos.end(), [&](const Openni2Info& info) { return info.uri_ == uri; });
}

/** \brief Opened by its number: with a URI that it does not know, PCL opens any device. */
std::unique_ptr<pcl::io::OpenNI2Grabber> openOpenni2Grabber(const std::string& name, const std::string& uri) {
  const std::vector<Openni2Info> infos = openni2Infos();
  const auto at = std::find_if(infos.begin(), infos.end(), [&](const Openni2Info& info) { return info.uri_ == uri; });
  std::unique_ptr<pcl::io::OpenNI2Grabber> grabber;
  try {
    grabber = std::make_unique<pcl::io::OpenNI2Grabber>("#" + std::to_string(at - infos.begin() + 1));
  } catch (const std::exception&) {
    throw InputError(
        name +
        ": cannot be opened; no other program may use it, its user must be allowed to use USB devices, and "
        "it must measure depth");
  }
  if (grabber->getDevice()->getUri() != uri)  // another was plugged in between
    throw InputError(name + ": the numbers of the devices have just changed; try again");
  return grabber;
}

class Openni2Device : public Device {
 public:
  Openni2Device(const std::string& name, std::string uri)
      : Device(name), uri_(std::move(uri)), grabber_(openOpenni2Grabber(name, uri_)) {
    camera_.name = cameraNameOf(name);
    try {
      describe();
    } catch (const std::exception&) {
      throw InputError(name + ": does not tell the size and the field of view of its images");
    }
    connectDepthGrabber(*grabber_, [this](std::uint64_t stamp, const std::shared_ptr<const LoadedView>& images) {
      const std::lock_guard<std::mutex> lock(mutex_);
      newest_ = {stamp, images};
      arrived_.notify_one();
    });
  }
  ~Openni2Device() override { grabber_.reset(); }  // its thread calls what follows it here

  const Camera& camera() const override { return camera_; }
  bool hasColor() const override { return has_color_; }
  std::vector<std::string> warnings() const override { return warnings_; }

  void start() override {
    try {
      grabber_->start();
    } catch (const std::exception&) {
      throw InputError(name() + ": cannot be started; it may need a USB controller of its own");
    }
  }

  std::optional<DeviceImages> wait(std::chrono::milliseconds longest) override {
    std::unique_lock<std::mutex> lock(mutex_);
    if (!arrived_.wait_for(lock, longest, [this] { return newest_.images != nullptr; })) return {};
    DeviceImages taken = std::exchange(newest_, {});
    lock.unlock();
    const DepthImage& depth = taken.images->depth16;
    if (depth.width != camera_.intrinsics.width || depth.height != camera_.intrinsics.height)
      throw InputError(name() + ": delivers images of another size than it told");
    if (!has_color_ && !taken.images->color.empty()) {
      const auto depth_alone = std::make_shared<LoadedView>();
      depth_alone->depth16 = depth;
      taken.images = depth_alone;
    }
    if (has_color_ && taken.images->color.empty() && !said_no_color_) {
      notice_ = name() + ": its colour cannot be brought to the size of its depth, and is left out";
      said_no_color_ = true;
    }
    return taken;
  }

  bool connected() override { return isOpenni2(openni2Infos(), uri_); }
  std::string notice() override { return std::exchange(notice_, {}); }

 private:
  /** \brief The driver has no calibration but the field of view. */
  void describe() {
    pcl::io::openni2::OpenNI2Device& device = *grabber_->getDevice();
    bool registered = false;
    if (device.hasColorSensor()) {
      if (device.isImageRegistrationModeSupported()) device.setImageRegistrationMode(true);
      registered = device.isDepthRegistered();
    }
    const auto depth = device.getDepthVideoMode();
    const int width = static_cast<int>(depth.x_resolution_), height = static_cast<int>(depth.y_resolution_);
    float focal_length = device.getDepthFocalLength();
    if (registered) {  // what it then delivers is what the colour camera sees
      const auto color_width = static_cast<float>(device.getColorVideoMode().x_resolution_);
      focal_length = device.getColorFocalLength() * static_cast<float>(width) / color_width;
    }
    camera_.intrinsics = centredLens(width, height, focal_length);
    camera_.depth_scale = 0.001f;
    checkCamera(camera_);
    has_color_ = registered;
    warnings_.push_back(name() +
                        ": its driver tells the field of view alone: no distortion and an optical axis through the "
                        "middle of the image are assumed");
    if (device.hasColorSensor() && !registered)
      warnings_.push_back(name() + ": its colour is left out, since its driver does not register depth to colour");
  }

  std::string uri_;
  Camera camera_;
  bool has_color_{false};
  bool said_no_color_{false};
  std::vector<std::string> warnings_;
  std::string notice_;
  std::mutex mutex_;
  std::condition_variable arrived_;
  DeviceImages newest_;
  std::unique_ptr<pcl::io::OpenNI2Grabber> grabber_;
};

/** \brief The URI of openni2:id among the connected. */
std::string openni2Uri(const std::string& id, const std::vector<Openni2Info>& infos) {
  const std::string name = "openni2:" + id;
  if (id.empty() && !infos.empty()) return infos[0].uri_;
  if (!id.empty() && id[0] == '#') {
    const std::optional<unsigned> number = deviceIndex(id.substr(1));
    if (!number || *number == 0) throw InputError(name + ": must be openni2:#1, openni2:#2, …, or openni2:URI");
    if (*number <= infos.size()) return infos[*number - 1].uri_;
  }
  if (isOpenni2(infos, id)) return id;
  failNotConnected(name, openni2Kind(), openni2List());
}

bool isSameOpenni2Model(const Openni2Info& a, const Openni2Info& b) {
  return a.vendor_id_ == b.vendor_id_ && a.product_id_ == b.product_id_;
}

/** \brief Where a device is after it was unplugged; empty while it is not there. Its URI may then end with another number, and devices of one model
 *  cannot be told apart by anything else: one that had no others of its model beside it is found again.
 *  \param others of its model that were connected, too */
std::string openni2UriAgain(const std::string& name, const Openni2Info& was, const std::vector<Openni2Info>& others) {
  const std::vector<Openni2Info> infos = openni2Infos();
  if (isOpenni2(infos, was.uri_)) return was.uri_;
  std::vector<std::string> fresh;
  for (const Openni2Info& info : infos)
    if (isSameOpenni2Model(info, was) && !isOpenni2(others, info.uri_)) fresh.push_back(info.uri_);
  if (fresh.empty()) return {};
  if (others.empty() && fresh.size() == 1) return fresh[0];
  throw InputError(name + ": a device of its model was plugged in, " + fresh[0] +
                   ", but nothing says that it is the same one; start again to use it");
}

std::unique_ptr<CameraSource> openOpenni2(const std::string& id) {
  const std::vector<Openni2Info> infos = openni2Infos();
  const std::string uri = openni2Uri(id, infos);
  const std::string name = "openni2:" + (id.empty() ? "#1" : id);
  const Openni2Info info =
      *std::find_if(infos.begin(), infos.end(), [&](const Openni2Info& known) { return known.uri_ == uri; });
  std::vector<Openni2Info> others;
  std::copy_if(infos.begin(), infos.end(), std::back_inserter(others),
               [&](const Openni2Info& other) { return other.uri_ != uri && isSameOpenni2Model(other, info); });
  return std::make_unique<DeviceSource>(std::make_unique<Openni2Device>(name, uri),
                                        [name, info, others]() -> std::unique_ptr<Device> {
                                          const std::string again = openni2UriAgain(name, info, others);
                                          if (again.empty()) return nullptr;
                                          return std::make_unique<Openni2Device>(name, again);
                                        });
}

}  // namespace

DeviceKind openni2Kind() { return {"openni2", "OpenNI 2 device", "", openOpenni2, openni2List}; }

}  // namespace fuse_flow::io

#else

namespace fuse_flow::io {

DeviceKind openni2Kind() {
  return {"openni2", "OpenNI 2 device", "OpenNI 2; install libopenni2-dev and a PCL that was built with it"};
}

}  // namespace fuse_flow::io

#endif
