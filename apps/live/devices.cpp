#include "live/devices.h"
namespace fuse_flow::io {
bool isDevice(const std::string& name) { return name.rfind("openni2:", 0) == 0; }
std::unique_ptr<CameraSource> openDevice(const std::string&) { throw InputError("stub"); }
std::vector<std::string> listDevices() { return {}; }
}  // namespace fuse_flow::io
