#pragma once

#include "live/camera_source.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief A device that is connected. */
struct ConnectedDevice {
  std::string name;   ///< that opens it, "realsense:0123"
  std::string model;  ///< for people
};

/** \brief What a library opens. */
struct DeviceKind {
  std::string scheme;  ///< "realsense"
  std::string called;  ///< "RealSense camera"
  /** \brief What must be installed before FUSE-Flow is built, where this build does not have it; else empty. */
  std::string missing;
  /** \brief Opens scheme:id. Null where the library is missing. Throws InputError. */
  std::unique_ptr<CameraSource> (*open)(const std::string& id){nullptr};
  /** \brief Null where the library is missing. Throws InputError if the library cannot tell. */
  std::vector<ConnectedDevice> (*list)(){nullptr};
};

DeviceKind openni2Kind();
DeviceKind realSenseKind();
DeviceKind k4aKind();
DeviceKind orbbecKind();
DeviceKind videoKind();

/** \brief Throws the InputError for a device that is not there: it says which devices of its kind are. */
[[noreturn]] void failNotConnected(const std::string& name, const DeviceKind& kind,
                                   const std::vector<ConnectedDevice>& connected);

/** \brief How messages begin: "k4a:0", and "k4a" of "k4a:", the first. */
std::string nameInMessages(const std::string& name);

/** \brief Camera::name of a device: what is no letter and no digit becomes one '_'. "openni2:#1" is openni2_1. */
std::string cameraNameOf(const std::string& device);

/** \brief "12" is 12. Nothing for what is not 1 to 3 digits, as serial numbers, which are longer. */
std::optional<unsigned> deviceIndex(const std::string& text);

}  // namespace fuse_flow::io
