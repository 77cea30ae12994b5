#pragma once

#include "recordings/messages/ros_messages.h"

#include <fuse_flow/math/pinhole.h>

#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief The lens that a CameraInfo describes: OpenCV's plumb_bob and rational_polynomial as they are; equidistant (Kannala and Brandt's), and
 *  RealSense's inverse and modified Brown–Conrady and F-Theta, by the Brown–Conrady lens that is nearest over the whole image, with a line that says how near. Throws InputError, beginning with
 *  owner, for an unknown model, and where none is within half a pixel.
 *  \param rectified the images are: the lens is ideal, with the projection matrix's numbers */
Intrinsics lensOf(const std::string& owner, const CameraInfoMessage& info, bool rectified,
                  std::vector<std::string>& warnings);

}  // namespace fuse_flow::io
