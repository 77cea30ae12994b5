#pragma once

#include "recordings/logs/message_log.h"
#include "recordings/streams/recorded_camera.h"

#include <memory>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief The depth cameras that a log holds. A camera is a namespace with topics of images: its depth, the colour next to it, and the camera_info of both; RealSense's own bags have a layout of
 *  their own. Where colour is from elsewhere than depth, tf, or the device's extrinsics, say how they stand. Throws InputError for a log without a camera.
 *  \param name of the camera, if the log has only one  \param use_color false: topics of colour are left alone  \param warnings what was assumed, and topics of images that are not used, are added */
std::vector<RecordedCamera> camerasOf(std::shared_ptr<MessageLog> log, const std::string& name, bool use_color,
                                      std::vector<std::string>& warnings);

}  // namespace fuse_flow::io
