#pragma once

#include "recordings/messages/ros_messages.h"

#include <fuse_flow/math/pinhole.h>

#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief The lens that a CameraInfo describes, see withDistortion(), in the part of the sensor and with the binning that it says. Throws InputError, beginning with
 *  owner.
 *  \param rectified the images are: the lens is ideal, with the projection matrix's numbers */
Intrinsics lensOf(const std::string& owner, const CameraInfoMessage& info, bool rectified,
                  std::vector<std::string>& warnings);

}  // namespace fuse_flow::io
