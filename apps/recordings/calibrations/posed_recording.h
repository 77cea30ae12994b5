#pragma once

#include <fuse_flow/recordings/recording.h>

#include <memory>
#include <string>

namespace fuse_flow::io {

/** \brief A recording whose cameras stand where a rig.json says, and whose depth is corrected as that says, such as fuse_flow_calibrate
 *  writes; found by their names. Throws
 *  InputError if it lacks one of them. */
std::unique_ptr<Recording> withPoses(std::unique_ptr<Recording> recording, const std::string& rig_json);

/** \brief A pose as a file has it, as camera to world of axes x right, y down, z forward. */
Eigen::Isometry3d converted(const Eigen::Isometry3d& pose, PoseConvention convention);

/** \brief A recording whose poses mean something else than its format says; itself, where they do not. */
std::unique_ptr<Recording> withConvention(std::unique_ptr<Recording> recording, PoseConvention convention);

}  // namespace fuse_flow::io
