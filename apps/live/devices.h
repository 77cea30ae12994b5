#pragma once

#include "live/camera_source.h"

#include <memory>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief Opens a connected camera by its name:
 *
 *  | name | camera | library |
 *  |---|---|---|
 *  | openni2:#1, openni2:URI, openni2: | the first, the one with this URI, the first | OpenNI 2, through PCL |
 *  | realsense:SERIAL, realsense: | the one with this serial number, the first | librealsense2 |
 *  | k4a:0, k4a:SERIAL, k4a: | the first, the one with this serial number, the first | libk4a |
 *  | orbbec:#1, orbbec:SERIAL, orbbec: | the first, the one with this serial number, the first | OrbbecSDK 2 |
 *  | video:/dev/video0, video:rtsp://… | a colour camera of Video4Linux, or with an address; see openVideoCamera() | libavformat, libavdevice |
 *
 *  Camera::name is "openni2_1", "realsense_SERIAL", "k4a_SERIAL" or "orbbec_SERIAL": letters, digits and '_' only, so that recordings of ROS keep it, and a rig.json that
 *  was made of one fits. Throws InputError, one line: for a name of another form, for a kind that this build does not open, and for a camera that is not connected. */
std::unique_ptr<CameraSource> openDevice(const std::string& name);

/** \brief Whether a name is that of a device, and not of a file: it begins with a scheme as "realsense:". Schemes of devices that cannot be opened,
 *  as "zed:", are some too: openDevice() says what is right. Upper and lower case matter. */
bool isDevice(const std::string& name);

/** \brief The connected devices, a line each: the name and the model, "realsense:0123 Intel RealSense D435". Of a kind of which none is connected,
 *  that this build does not open, or whose library cannot tell, a line says so. */
std::vector<std::string> listDevices();

}  // namespace fuse_flow::io
