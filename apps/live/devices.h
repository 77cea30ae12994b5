#pragma once

#include "live/camera_source.h"

#include <memory>
#include <string>
#include <vector>

namespace fuse_flow::io {
bool isDevice(const std::string& name);
std::unique_ptr<CameraSource> openDevice(const std::string& name);
std::vector<std::string> listDevices();
}  // namespace fuse_flow::io
