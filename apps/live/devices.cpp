#include "live/devices.h"

#include "live/device_kinds.h"

#include <algorithm>
#include <array>
#include <cctype>

namespace fuse_flow::io {
namespace {

std::array<DeviceKind, 5> deviceKinds() {
  return {openni2Kind(), realSenseKind(), k4aKind(), orbbecKind(), videoKind()};
}

constexpr const char* kDeviceForms =
    "openni2:#1 or openni2:URI, realsense:SERIAL, k4a:0 or k4a:SERIAL, orbbec:#1 or orbbec:SERIAL, or "
    "video:/dev/video0 "
    "or video:rtsp://… of colour cameras; the first of a kind is openni2:, realsense:, k4a: or orbbec:";

/** \brief What people may try, and what to do with it. */
struct OtherScheme {
  const char* scheme;
  const char* instead;
};
constexpr OtherScheme kOtherSchemes[] = {
    {"femto", "Femto are orbbec:, or k4a: with Orbbec's K4A wrapper"},
    {"gemini", "Gemini are orbbec:"},
    {"astra", "Astra are openni2:, Astra 2 orbbec:"},
    {"kinect", "Azure Kinect is k4a:, the Kinect of the Xbox 360 openni2:"},
    {"freenect", "the Kinect of the Xbox 360 is openni2:"},
    {"freenect2", "the Kinect of the Xbox One is openni2: with the driver of libfreenect2"},
    {"openni", "OpenNI 2 is openni2:"},
    {"v4l2", "USB cameras are video:/dev/video0 and so on"},
    {"webcam", "USB cameras are video:/dev/video0 and so on"},
    {"rtsp", "cameras with an address are video:rtsp://…"},
    {"rs", "RealSense cameras are realsense:"},
    {"zed", "record it with its own program, or with ROS 2"},
    {"oak", "record it with its own program, or with ROS 2"},
    {"depthai", "record it with its own program, or with ROS 2"},
};

const OtherScheme* otherScheme(const std::string& scheme) {
  const auto* const found = std::find_if(std::begin(kOtherSchemes), std::end(kOtherSchemes),
                                         [&](const OtherScheme& other) { return scheme == other.scheme; });
  return found == std::end(kOtherSchemes) ? nullptr : found;
}

/** \brief "realsense" of "realsense:0123"; empty where there is no colon. */
std::string deviceScheme(const std::string& name) {
  const std::size_t colon = name.find(':');
  return colon == std::string::npos ? "" : name.substr(0, colon);
}

}  // namespace

bool isDevice(const std::string& name) {
  const std::string scheme = deviceScheme(name);
  const auto kinds = deviceKinds();
  return otherScheme(scheme) ||
         std::any_of(kinds.begin(), kinds.end(), [&](const DeviceKind& kind) { return kind.scheme == scheme; });
}

std::unique_ptr<CameraSource> openDevice(const std::string& name) {
  const std::string scheme = deviceScheme(name);
  for (const DeviceKind& kind : deviceKinds()) {
    if (kind.scheme != scheme) continue;
    if (!kind.open)
      throw InputError(nameInMessages(name) + ": cannot be opened, since FUSE-Flow was built without " + kind.missing +
                       ", and build it again");
    return kind.open(name.substr(scheme.size() + 1));
  }
  if (const OtherScheme* other = otherScheme(scheme))
    throw InputError(nameInMessages(name) + ": cannot be opened; " + other->instead + "; must be " + kDeviceForms);
  throw InputError(name + ": is no device, must be " + kDeviceForms);
}

std::vector<std::string> listDevices() {
  std::vector<std::string> lines;
  for (const DeviceKind& kind : deviceKinds()) {
    if (!kind.list) {
      lines.push_back(kind.scheme + ": is not looked for, since FUSE-Flow was built without " + kind.missing +
                      ", and build it again");
      continue;
    }
    try {
      const std::vector<ConnectedDevice> connected = kind.list();
      for (const ConnectedDevice& device : connected) lines.push_back(device.name + " " + device.model);
      if (connected.empty()) lines.push_back(kind.scheme + ": no " + kind.called + " is connected");
    } catch (const InputError& error) {
      lines.push_back(error.what());
    }
  }
  return lines;
}

void failNotConnected(const std::string& name, const DeviceKind& kind, const std::vector<ConnectedDevice>& connected) {
  if (connected.empty()) throw InputError(nameInMessages(name) + ": no " + kind.called + " is connected");
  std::string names;
  for (const ConnectedDevice& device : connected)
    names += (names.empty() ? "" : ", ") + device.name + " (" + device.model + ")";
  throw InputError(nameInMessages(name) + ": is not connected; connected: " + names);
}

std::string nameInMessages(const std::string& name) {
  const bool first = !name.empty() && name.back() == ':';
  return first ? name.substr(0, name.size() - 1) : name;
}

std::string cameraNameOf(const std::string& device) {
  std::string name;
  for (const char c : device) {
    const bool kept = std::isalnum(static_cast<unsigned char>(c)) != 0;
    if (kept)
      name += c;
    else if (name.empty() || name.back() != '_')
      name += '_';
  }
  return name;
}

std::optional<unsigned> deviceIndex(const std::string& text) {
  constexpr std::size_t most_digits = 3;
  if (text.empty() || text.size() > most_digits || text.find_first_not_of("0123456789") != std::string::npos) return {};
  return static_cast<unsigned>(std::stoul(text));
}

}  // namespace fuse_flow::io
