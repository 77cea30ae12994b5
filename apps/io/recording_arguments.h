#pragma once

#include "io/option_checks.h"
#include "io/recording.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief Which recording, and how to look at it, on the command line. */
class RecordingArguments {
 public:
  explicit RecordingArguments(CLI::App& app) {
    input_ = app.add_option(
        "input", inputs_,
        "a rig recording (folder with rig.json), a 7-Scenes, TUM RGB-D or Redwood folder, or organised PCD files");
    app.add_option("--views", options_.views, "frames that act as the cameras of one instant: 0,60,120 or A:B:STEP")
        ->multi_option_policy(CLI::MultiOptionPolicy::Join);
    app.add_option("--slide", options_.slide, "move those views on by this many frames, again and again")
        ->check(wholeNumber(0, std::numeric_limits<int>::max()));
    app.add_option("--depth-scale", options_.depth_scale, "metres per unit of depth, instead of the recording's own")
        ->check(positiveNumber());
    app.add_option("--poses", options_.poses,
                   "rig.json whose poses replace the recording's, as fuse_flow_calibrate writes it");
  }
  RecordingArguments(const RecordingArguments&) = delete;
  RecordingArguments& operator=(const RecordingArguments&) = delete;

  CLI::Option* input() { return input_; }
  const std::vector<std::string>& inputs() const { return inputs_; }
  RecordingOptions options() const {
    RecordingOptions result = options_;
    result.views = joinedList(result.views);
    return result;
  }

 private:
  CLI::Option* input_;
  std::vector<std::string> inputs_;
  RecordingOptions options_;
};

}  // namespace fuse_flow::io
