#pragma once

#include "stereo/stereo_recording.h"

#include <CLI/CLI.hpp>

#include <map>
#include <string>

namespace fuse_flow::command_line {

/** \brief How depth is estimated for views that have none, on the command line. */
class StereoArguments {
 public:
  /** \param may_be_off whether --no-stereo makes sense */
  explicit StereoArguments(CLI::App& app, bool may_be_off = true);
  StereoArguments(const StereoArguments&) = delete;
  StereoArguments& operator=(const StereoArguments&) = delete;

  /** \brief With a line on the standard error stream where the images of a frame do not fit. Throws OptionError.
   *  \param tool its name */
  io::StereoOptions options(const std::string& tool) const;

 private:
  bool estimate_{true};
  StereoParameters parameters_;
  /** \brief What the library calls a parameter, and its option. */
  std::map<std::string, std::string> option_of_;
};

}  // namespace fuse_flow::command_line
