// Writes cameras as they run, or a recording, as one MCAP file, which ROS 2 and Foxglove read.

#include "command_line/arguments/live_arguments.h"
#include "command_line/arguments/option_checks.h"
#include "command_line/arguments/recording_arguments.h"
#include "command_line/tool.h"
#include "live/rig_recorder.h"
#include "recordings/absent_images.h"
#include "recordings/files/file_io.h"
#include "recordings/files/interrupt.h"
#include "recordings/pool.h"
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
  bool play{false};
  double status{5};
  io::RecordingOptions recording;
  io::RigRecorder::Options recorder;
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

void warn(const std::vector<std::string>& lines) { command_line::printWarnings("fuse_flow_record", lines); }

double secondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/** \brief Every frame of a recording, as fast as it goes. */
int convert(const Options& options) {
  const std::unique_ptr<io::Recording> recording =
      command_line::openRecording("fuse_flow_record", options.inputs, options.recording);
  const std::vector<std::size_t> frames = io::chooseFrames(*recording, options.frames);
  command_line::prepareRecording("-o", options.output, io::InputFiles(recording->inputs()));
  std::vector<bool> has_color;
  for (std::size_t k = 0; k < recording->cameras().size(); ++k) has_color.push_back(recording->hasColor(k));
  io::RigRecorder::Options recorder_options = options.recorder;
  recorder_options.waits = true;
  io::RigRecorder recorder(options.output, recording->cameras(), has_color, recorder_options);
  warn(recorder.warnings());
  io::catchInterrupts();
  const io::StillThere still_there(*recording);
  io::ReadAhead ahead(*recording, frames, 2);
  io::Pool<io::LoadedFrame> pool;
  FrameTimes times;
  const auto start = std::chrono::steady_clock::now();
  std::size_t done = 0;
  for (; done < frames.size() && !io::interrupt_requested; ++done) {
    const std::shared_ptr<io::LoadedFrame> frame = pool.next();
    ahead.next(*frame);
    io::clearAbsentImages(*frame);
    still_there.check(*frame);
    requireStandingCameras(options.inputs[0], *recording, frame->rig);
    const io::Nanoseconds time = times.of(frame->rig);
    for (std::size_t k = 0; k < frame->images.size(); ++k)
      recorder.take(k, time, std::shared_ptr<const io::LoadedView>(frame, &frame->images[k]));
    recorder.check();
  }
  recorder.finish();
  const double seconds = secondsSince(start);
  warn(recorder.leftOut());
  if (times.assumed()) warn({"the recording does not say when its frames were taken; 30 a second are taken"});
  std::printf("%s: %zu frames of %zu cameras, %.1f MB, %.1f frames per second\n", options.output.c_str(), done,
              recording->cameras().size(), static_cast<double>(recorder.bytes()) * 1e-6,
              static_cast<double>(done) / seconds);
  return command_line::endOfFrames("fuse_flow_record", done, frames.size());
}

/** \brief Every view of cameras that run, until somebody ends it. */
int record(const Options& options, const command_line::LiveArguments& live) {
  if (!options.frames.empty())
    throw io::OptionError("--frames: is for a recording that becomes another file; must be --play-frames with --play");
  const std::unique_ptr<io::LiveRig> rig = live.open("fuse_flow_record", options.inputs, options.recording, true);
  if (const std::vector<std::string> lost = rig->withoutPoses(); !lost.empty())
    warn(
        {"where the cameras stand is not known, and is not in the file: fuse_flow_calibrate finds it, and --poses says "
         "it"});
  command_line::prepareRecording("-o", options.output, io::InputFiles(rig->inputs()));
  io::RigRecorder recorder(options.output, *rig, options.recorder);
  warn(recorder.warnings());
  io::catchInterrupts();
  rig->start();
  const auto start = std::chrono::steady_clock::now();
  command_line::LiveLog log("fuse_flow_record", options.status);
  io::LiveInstant instant;
  while (!io::interrupt_requested && rig->running() && secondsSince(start) < live.seconds().value_or(1e12)) {
    // Frames are put together to see whether they can be.
    for (int k = 0; k < 100 && rig->next(std::chrono::milliseconds(20), instant); ++k) {
    }
    recorder.check();
    log.look(*rig, [&] {
      return std::to_string(recorder.written()) + " views written, " + std::to_string(recorder.lost()) +
             " lost for want of time";
    });
  }
  rig->stop();
  recorder.finish();
  const double seconds = secondsSince(start);
  log.look(*rig, [] { return std::string(); });
  warn(recorder.leftOut());
  const SynchronizerStatistics statistics = rig->statistics();
  std::printf("%s: %llu views of %zu cameras in %.1f s, %.1f MB\n", options.output.c_str(),
              static_cast<unsigned long long>(recorder.written()), rig->cameras().size(), seconds,
              static_cast<double>(recorder.bytes()) * 1e-6);
  std::printf("  %llu frames, %llu of them without all cameras, up to %.1f ms apart\n",
              static_cast<unsigned long long>(statistics.complete_sets + statistics.incomplete_sets),
              static_cast<unsigned long long>(statistics.incomplete_sets),
              1e-3 * static_cast<double>(statistics.largest_spread.count()));
  std::cout << command_line::LiveLog::summary(*rig);
  if (recorder.written() == 0) warn({"no image came, and the file is empty"});
  if (recorder.lost() > 0) {
    std::cout << std::flush;
    warn({std::to_string(recorder.lost()) +
          " views are not in the file: they came faster than they could be compressed and written; a lower "
          "--color-quality, fewer cameras or more cores are needed"});
  }
  return command_line::kSuccess;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app(
      "Writes cameras as they run, or a recording, as one MCAP file, which ROS 2, Foxglove and these tools read. Depth "
      "loses nothing.",
      "fuse_flow_record");
  command_line::RecordingArguments recording(app);
  recording.input()->required();
  app.add_option("-o,--output", options.output, "a .mcap file")->check(command_line::path())->required();
  app.add_option("--frames", options.frames, "of a recording: A:B:STEP, B not included")
      ->multi_option_policy(CLI::MultiOptionPolicy::Join);
  app.add_option("--compression", options.recorder.messages.compression,
                 "of the file, beside that of its images: a few per cent, for reading more slowly; none, the default, "
                 "lz4 or zstd")
      ->check(CLI::IsMember({"none", "lz4", "zstd"}));
  app.add_option("--color-quality", options.recorder.messages.color_quality,
                 "of colour, by JPEG, 1-100; depth loses nothing")
      ->check(command_line::wholeNumber(1, 100))
      ->capture_default_str();
  app.add_option("--threads", options.recorder.threads, "that compress; 0: one per core")
      ->check(command_line::threadCount())
      ->capture_default_str();
  app.add_flag("--play", options.play, "play the recording as if its cameras ran, at their rate, and record them");
  app.add_option("--status", options.status, "of cameras that run: seconds between two reports; 0: none")
      ->check(command_line::nonNegativeNumber())
      ->capture_default_str();
  command_line::LiveArguments live(app);
  return command_line::runTool(app, argc, argv, [&] {
    options.frames = command_line::joinedList(options.frames);
    options.inputs = recording.inputs();
    options.recording = recording.options();
    if (options.recorder.messages.compression == "none") options.recorder.messages.compression.clear();
    if (options.play || command_line::LiveArguments::anyDevice(options.inputs)) return record(options, live);
    if (const std::vector<std::string> given = live.given(); !given.empty())
      throw io::OptionError(given[0] + ": is for cameras that run; must be with a device, or with --play");
    return convert(options);
  });
}
