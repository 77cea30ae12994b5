// Writes a recording as one MCAP file, which ROS 2 and Foxglove read.

#include "command_line/option_checks.h"
#include "command_line/recording_arguments.h"
#include "command_line/stereo_arguments.h"
#include "command_line/tool.h"
#include "recordings/files/file_io.h"
#include "recordings/files/interrupt.h"
#include "recordings/messages/rig_messages.h"
#include "recordings/range.h"
#include "recordings/read_ahead.h"
#include "recordings/still_there.h"

#include <fuse_flow/recordings/input_files.h>

#include <chrono>
#include <cmath>
#include <iostream>

namespace {

using namespace fuse_flow;

struct Options {
  std::vector<std::string> inputs;
  std::string output;
  std::string frames;
  io::RecordingOptions recording;
  io::RigMessages::Options messages;
};

/** \brief Of a frame: the recording's, or, where it has none, thirty a second. */
class FrameTimes {
 public:
  io::Nanoseconds of(const RigFrame& rig) {
    constexpr io::Nanoseconds assumed = 33'333'333;
    io::Nanoseconds time = static_cast<io::Nanoseconds>(rig.stamp) * 1000;
    if (last_ && time <= *last_) {
      assumed_ = true;
      time = *last_ + assumed;
    }
    last_ = time;
    return time;
  }
  bool assumed() const { return assumed_; }

 private:
  std::optional<io::Nanoseconds> last_;
  bool assumed_{false};
};

/** \brief The file has one pose of a camera. */
void requireStandingCameras(const std::string& input, const io::Recording& recording, const RigFrame& rig) {
  for (std::size_t k = 0; k < rig.cameras.size(); ++k)
    if (!sameCalibration(rig.cameras[k], recording.cameras()[k]))
      throw io::InputError(input + ": camera '" + rig.cameras[k].name +
                           "' is elsewhere than in the first frame, as with --slide; its cameras must stand");
}

int run(const Options& options) {
  io::StereoOptions no_stereo;
  no_stereo.estimate = false;
  const std::unique_ptr<io::Recording> recording =
      command_line::openRecording("fuse_flow_record", options.inputs, options.recording, no_stereo);
  const std::vector<std::size_t> frames = io::chooseFrames(*recording, options.frames);
  io::InputFiles inputs(recording->inputs());
  inputs.refuseToReplace("-o", options.output);
  if (options.output.size() < 5 || options.output.substr(options.output.size() - 5) != ".mcap")
    throw io::OptionError("-o " + options.output + ": must end in .mcap");
  std::vector<bool> has_color;
  for (std::size_t k = 0; k < recording->cameras().size(); ++k) has_color.push_back(recording->hasColor(k));
  io::makeFolderOf(options.output);
  io::RigMessages messages(options.output, recording->cameras(), has_color, options.messages);
  command_line::printWarnings("fuse_flow_record", messages.warnings());
  io::catchInterrupts();
  const io::StillThere still_there(*recording);
  io::ReadAhead ahead(*recording, frames, 2);
  io::LoadedFrame frame;
  FrameTimes times;
  const auto start = std::chrono::steady_clock::now();
  std::size_t done = 0;
  bool confidence = false;
  for (; done < frames.size() && !io::interrupt_requested; ++done) {
    ahead.next(frame);
    still_there.check(frame);
    requireStandingCameras(options.inputs[0], *recording, frame.rig);
    for (const DepthView& view : frame.rig.views) confidence = confidence || view.confidence;
    messages.write(times.of(frame.rig), frame);
  }
  messages.finish();
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (confidence)
    command_line::printWarnings("fuse_flow_record",
                                {"the cameras' images of confidence have no place in such a file, and are left out"});
  if (times.assumed())
    command_line::printWarnings("fuse_flow_record",
                                {"the recording does not say when its frames were taken; 30 a second are taken"});
  std::printf("%s: %zu frames of %zu cameras, %.1f MB, %.1f frames per second\n", options.output.c_str(), done,
              recording->cameras().size(), static_cast<double>(io::fileSize(options.output)) * 1e-6,
              static_cast<double>(done) / seconds);
  return command_line::endOfFrames("fuse_flow_record", done, frames.size());
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Writes a recording as one MCAP file, which ROS 2, Foxglove and these tools read.", "fuse_flow_record");
  command_line::RecordingArguments recording(app);
  recording.input()->required();
  app.add_option("-o,--output", options.output, "a .mcap file")->check(command_line::path())->required();
  app.add_option("--frames", options.frames, "A:B:STEP, B not included")
      ->multi_option_policy(CLI::MultiOptionPolicy::Join);
  app.add_option("--compression", options.messages.compression,
                 "of the file, beside that of its images: a few per cent, for reading more slowly; none, the default, "
                 "lz4 or zstd")
      ->check(CLI::IsMember({"none", "lz4", "zstd"}));
  app.add_option("--color-quality", options.messages.color_quality, "of colour, by JPEG, 1-100; depth loses nothing")
      ->check(command_line::wholeNumber(1, 100))
      ->capture_default_str();
  return command_line::runTool(app, argc, argv, [&] {
    options.frames = command_line::joinedList(options.frames);
    options.inputs = recording.inputs();
    options.recording = recording.options();
    if (options.messages.compression == "none") options.messages.compression.clear();
    return run(options);
  });
}
