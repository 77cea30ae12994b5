#include "command_line/recording_arguments.h"

#include "command_line/option_checks.h"

#include <limits>

namespace fuse_flow::command_line {

RecordingArguments::RecordingArguments(CLI::App& app) {
  input_ = app.add_option(
      "input", inputs_,
      "a rig recording (folder with rig.json), a 7-Scenes, TUM RGB-D or Redwood folder, or organised PCD files");
  app.add_option(
         "--views", options_.views,
         "frames that act as the cameras of one instant: 0,60,120 or A:B:STEP; of a rig recording, the cameras to use")
      ->multi_option_policy(CLI::MultiOptionPolicy::Join);
  app.add_option("--slide", options_.slide, "move those views on by this many frames, again and again")
      ->check(wholeNumber(0, std::numeric_limits<int>::max()));
  app.add_option("--depth-scale", options_.depth_scale, "metres per unit of depth, instead of the recording's own")
      ->check(positiveNumber());
  app.add_option("--poses", options_.poses,
                 "rig.json whose poses and depth corrections replace the recording's, as fuse_flow_calibrate writes it")
      ->check(path());
}

io::RecordingOptions RecordingArguments::options() const {
  io::RecordingOptions result = options_;
  result.views = joinedList(result.views);
  return result;
}

}  // namespace fuse_flow::command_line
