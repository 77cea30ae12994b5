#pragma once

#include "stereo/stereo_recording.h"

#include <fuse_flow/recordings/recording.h>

#include <CLI/CLI.hpp>

#include <memory>
#include <string>
#include <vector>

namespace fuse_flow::command_line {

/** \brief --intrinsics and --pose-convention. */
void addCalibrationOptions(CLI::App& app, io::RecordingOptions& options);

/** \brief Says on the standard error stream what was assumed or left out, a line each. \param tool its name */
void printWarnings(const std::string& tool, const std::vector<std::string>& warnings);

/** \brief openRecording() of io, and then printWarnings(). Cameras without depth stay without. */
std::unique_ptr<io::Recording> openRecording(const std::string& tool, const std::vector<std::string>& inputs,
                                             const io::RecordingOptions& options);
/** \brief The same, withStereo(); where none is to be estimated, a line says how many cameras are missing. */
std::unique_ptr<io::Recording> openRecording(const std::string& tool, const std::vector<std::string>& inputs,
                                             const io::RecordingOptions& options, const io::StereoOptions& stereo);

/** \brief Says that cameras are missing, since they have colour images alone. \param lacks_depth of each camera */
void warnOfMissingDepth(const std::string& tool, const std::vector<bool>& lacks_depth);

/** \brief Which recording, and how to look at it, on the command line. */
class RecordingArguments {
 public:
  explicit RecordingArguments(CLI::App& app);
  RecordingArguments(const RecordingArguments&) = delete;
  RecordingArguments& operator=(const RecordingArguments&) = delete;

  CLI::Option* input() { return input_; }
  const std::vector<std::string>& inputs() const { return inputs_; }
  io::RecordingOptions options() const;

 private:
  CLI::Option* input_;
  std::vector<std::string> inputs_;
  io::RecordingOptions options_;
};

}  // namespace fuse_flow::command_line
