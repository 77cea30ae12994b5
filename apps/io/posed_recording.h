#pragma once

#include "io/recording.h"

#include <memory>
#include <string>

namespace fuse_flow::io {

/** \brief A recording whose cameras stand where a rig.json says, and whose depth is corrected as that says, such as fuse_flow_calibrate
 *  writes; found by their names. Throws
 *  InputError if it lacks one of them. */
std::unique_ptr<Recording> withPoses(std::unique_ptr<Recording> recording, const std::string& rig_json);

}  // namespace fuse_flow::io
