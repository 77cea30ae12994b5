#pragma once

#include "live/device_source.h"

#include <chrono>
#include <memory>
#include <string>

namespace fuse_flow::io {

/** \brief A colour camera that libavformat opens: a USB camera of Video4Linux, "/dev/video0", with options behind a question mark
 *  ("/dev/video0?video_size=1280x720&framerate=30&input_format=mjpeg"), or an address, "rtsp://…", "http://…", "tcp://…", "udp://…". Its intrinsics are not known.
 *  Throws InputError. */
std::unique_ptr<Device> openVideoCamera(const std::string& id);

/** \brief How long a camera may take until its first picture. */
constexpr std::chrono::seconds kVideoPatience{10};

/** \brief The same as a source, which is looked for again when it goes away; its stop() waits for nothing. \param patience see kVideoPatience */
std::unique_ptr<CameraSource> openVideoSource(const std::string& id, std::chrono::seconds patience);

}  // namespace fuse_flow::io
