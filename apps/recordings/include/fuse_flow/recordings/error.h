#pragma once

#include <stdexcept>
#include <string>

namespace fuse_flow::io {

/** \brief Something that was given cannot be used. The message is one line: the path, what is wrong, what would be right. */
struct InputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/** \brief An option cannot be used as it was given, or not with this recording. The message begins with the option as the
 *  tools call it: --depth-scale is RecordingOptions::depth_scale. */
struct OptionError : InputError {
  using InputError::InputError;
};

/** \brief A result could not be written. The message is one line; nothing half-written is left behind. */
struct OutputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace fuse_flow::io
