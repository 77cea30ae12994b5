#pragma once

#include <stdexcept>
#include <string>

namespace fuse_flow::io {

/** \brief An input cannot be used. The message is one line: the path, the error, and the correct form. */
struct InputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/** \brief The value of an option is wrong, or the option cannot be used with this recording. The message begins with the name of the option
 *  in the tools: --depth-scale for RecordingOptions::depth_scale. */
struct OptionError : InputError {
  using InputError::InputError;
};

/** \brief A result could not be written. The message is one line; no partly written file remains. */
struct OutputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace fuse_flow::io
