#include "command_line/arguments/live_arguments.h"

#include "command_line/arguments/option_checks.h"
#include "command_line/arguments/recording_arguments.h"
#include "live/devices.h"
#include "recordings/files/file_io.h"
#include "recordings/range.h"

#include <fuse_flow/recordings/rig_json.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iostream>

namespace fuse_flow::command_line {
namespace {

constexpr double kDay = 86400;  // seconds

std::chrono::microseconds microseconds(double milliseconds) {
  return std::chrono::microseconds(static_cast<std::int64_t>(1e3 * milliseconds));
}

/** \brief "left:3:2", the camera by its name or its position. */
io::PlayOptions::Stall parseStall(const std::string& text, const std::vector<Camera>& cameras) {
  const auto wrong = [&](const std::string& why) -> io::OptionError {
    return io::OptionError("--stall " + text + ": " + why);
  };
  const std::size_t second = text.rfind(':');
  const std::size_t first =
      second == std::string::npos || second == 0 ? std::string::npos : text.rfind(':', second - 1);
  if (first == std::string::npos) throw wrong("must be CAMERA:FROM:SECONDS, as left:3:2");
  io::PlayOptions::Stall stall;
  char rest = 0;
  if (std::sscanf(text.c_str() + first + 1, "%lf:%lf%c", &stall.from, &stall.duration, &rest) != 2 ||
      !(stall.from >= 0 && stall.from <= kDay) || !(stall.duration > 0 && stall.duration <= kDay))
    throw wrong("after the camera must be seconds, from when and how long");
  const std::string name = text.substr(0, first);
  std::string names;
  for (std::size_t k = 0; k < cameras.size(); ++k) {
    stall.camera = k;
    if (cameras[k].name == name || std::to_string(k) == name) return stall;
    names += (names.empty() ? "'" : ", '") + cameras[k].name + "'";
  }
  throw wrong("there is no camera '" + name + "', must be one of " + names);
}

}  // namespace

LiveArguments::LiveArguments(CLI::App& app, bool loops) {
  play_.loop = loops;
  const auto milliseconds = numberFromTo(0.001, 3600000);
  options_.push_back(
      app.add_option("--seconds", seconds_, "end after so many; default: when the recording or you end it")
          ->check(positiveNumberUpTo(365 * kDay)));
  options_.push_back(app.add_option("--tolerance", tolerance_ms_,
                                    "views of one instant: largest difference in time to its middle, ms; cameras that "
                                    "run freely: half of their period")
                         ->check(milliseconds)
                         ->capture_default_str());
  options_.push_back(
      app.add_option("--max-wait", max_wait_ms_,
                     "longest time that a view waits for those of other cameras, ms; above the period of "
                     "the slowest camera")
          ->check(milliseconds)
          ->capture_default_str());
  const std::string of_play = "of a recording that is played: ";
  of_play_ = {
      app.add_option("--play-frames", frames_, of_play + "its frames, A:B:STEP, B not included")
          ->multi_option_policy(CLI::MultiOptionPolicy::Join),
      app.add_option("--speed", play_.speed,
                     (loops ? "of a recording, or of a stream that was kept: " : of_play) + "1: as it was taken")
          ->check(numberFromTo(0.001, 1000))
          ->capture_default_str(),
      loops ? app.add_flag("!--once", play_.loop, of_play + "once, and then end; default: again and again")
            : app.add_flag("--loop", play_.loop, of_play + "again and again"),
      app.add_option("--jitter", jitter_ms_, of_play + "views arrive later by up to so many ms")
          ->check(numberFromTo(0, 10000))
          ->capture_default_str(),
      app.add_option("--drop", play_.drop, of_play + "share of its views that each camera loses")
          ->check(numberFromTo(0, 1))
          ->capture_default_str(),
      app.add_option("--stall", stalls_,
                     of_play + "CAMERA:FROM:SECONDS: a camera that delivers nothing for a while, as one that is "
                               "unplugged; again for more"),
      app.add_flag("--own-clocks", play_.own_clocks, of_play + "each camera has a clock of its own"),
      app.add_flag("--preload", play_.preload, of_play + "all of it is read into memory before it begins")};
}

bool LiveArguments::anyDevice(const std::vector<std::string>& inputs) {
  return std::any_of(inputs.begin(), inputs.end(), [](const std::string& input) { return io::isDevice(input); });
}

std::vector<std::string> LiveArguments::given() const {
  std::vector<std::string> names;
  for (const std::vector<CLI::Option*>& some : {options_, of_play_})
    for (const CLI::Option* option : some)
      if (option->count() > 0) names.push_back(option->get_name());
  return names;
}

std::unique_ptr<io::CameraSource> LiveArguments::openPlayed(const std::string& tool,
                                                            const std::vector<std::string>& inputs,
                                                            const io::RecordingOptions& options,
                                                            const io::RankPart& part) const {
  io::RecordingOptions with_gaps = options;
  with_gaps.skip_damaged = true;  // cameras that run do not end for one image
  with_gaps.part = part.part;
  with_gaps.parts = part.parts;
  std::unique_ptr<io::Recording> recording = openRecording(tool, inputs, with_gaps);
  io::PlayOptions play = play_;
  play.jitter = 1e-3 * jitter_ms_;
  for (const std::string& stall : stalls_) play.stalls.push_back(parseStall(stall, recording->cameras()));
  play.part = part.part;
  play.parts = part.parts;
  std::vector<std::size_t> frames = io::chooseFrames(*recording, joinedList(frames_), "--play-frames");
  return std::make_unique<io::PlayedCameras>(std::move(recording), std::move(frames), play);
}

std::string LiveArguments::played(const std::vector<std::string>& inputs) const {
  std::string text;
  std::error_code error;
  for (const std::string& input : inputs)
    text +=
        (text.empty() ? "" : " ") + std::filesystem::weakly_canonical(std::filesystem::absolute(input), error).string();
  for (const CLI::Option* option : of_play_)
    if (option->count() > 0) text += " " + option->get_name() + " " + CLI::detail::join(option->results(), ",");
  return text;
}

LiveArguments::Sources LiveArguments::openSources(const std::string& tool, const std::vector<std::string>& inputs,
                                                  const io::RecordingOptions& recording, Ranks* ranks) const {
  Sources sources;
  const bool devices = anyDevice(inputs);
  io::RankPart part;
  if (ranks != nullptr) part = io::partOfPlayed(ranks->patientCommunicator(), devices ? "" : played(inputs));
  if (inputs.empty()) return sources;
  if (!devices) {
    if (ranks != nullptr && !recording.views.empty())
      throw io::OptionError("--views: ranks share out all cameras of a recording that is played, must be left out");
    if (ranks != nullptr && play_.preload)
      throw io::OptionError("--preload: each rank would begin when it has read its own part, must be left out");
    std::unique_ptr<io::CameraSource> source = openPlayed(tool, inputs, recording, part);
    if (!source->cameras().empty()) sources.push_back(std::move(source));
    return sources;
  }
  for (const std::string& input : inputs)
    if (!io::isDevice(input))
      throw io::InputError(input + ": is no device, as the others are; must be devices alone, or a recording alone");
  for (const CLI::Option* option : of_play_)
    if (option->count() > 0)
      throw io::OptionError(option->get_name() + ": is for a recording that is played, and " + inputs[0] +
                            " is a device");
  for (const auto& [set, option] : {std::pair{!recording.views.empty(), "--views"},
                                    {recording.slide != 0, "--slide"},
                                    {recording.depth_scale.has_value(), "--depth-scale"},
                                    {!recording.time_offsets.empty(), "--time-offsets"},
                                    {!recording.intrinsics.empty(), "--intrinsics"}})
    if (set) throw io::OptionError(std::string(option) + ": " + inputs[0] + " is a device, which says it itself");
  for (const std::string& input : inputs) sources.push_back(io::openDevice(input));
  return sources;
}

std::unique_ptr<io::LiveRig> LiveArguments::rigOf(const std::string& tool, Sources sources,
                                                  const io::RecordingOptions& recording, bool devices,
                                                  bool without_poses) const {
  io::LiveRig::Options options;
  options.synchronizer.tolerance = microseconds(tolerance_ms_);
  options.synchronizer.max_wait = microseconds(max_wait_ms_);
  options.one_clock = !devices;
  auto rig = std::make_unique<io::LiveRig>(std::move(sources), options);
  if (devices && !recording.poses.empty()) {
    const io::RigDescription calibrated = io::readRigJson(recording.poses);
    printWarnings(tool, calibrated.warnings);
    rig->setPoses(recording.poses, calibrated.cameras);
  }
  if (const std::vector<std::string> lost = rig->withoutPoses(); !lost.empty() && !without_poses)
    throw io::InputError("nobody knows where camera '" + lost[0] +
                         "' stands: --poses rig.json says it; fuse_flow_record and then fuse_flow_calibrate make one");
  if (const std::vector<std::string> unknown = rig->withoutIntrinsics(); !unknown.empty())
    throw io::InputError("camera '" + unknown[0] +
                         "' does not know its intrinsics: --poses rig.json must say them, as they are of its images");
  printWarnings(tool, rig->warnings());
  return rig;
}

std::unique_ptr<io::LiveRig> LiveArguments::open(const std::string& tool, const std::vector<std::string>& inputs,
                                                 const io::RecordingOptions& recording, bool without_poses) const {
  io::RecordingOptions options = recording;
  options.without_poses = without_poses;
  return rigOf(tool, openSources(tool, inputs, options, nullptr), recording, anyDevice(inputs), without_poses);
}

std::unique_ptr<io::LiveRig> LiveArguments::open(const std::string& tool, const std::vector<std::string>& inputs,
                                                 const io::RecordingOptions& recording, io::LeadingRank& leader,
                                                 Ranks& ranks) const {
  Sources sources = leader.meet(openSources(tool, inputs, recording, &ranks), ranks.patientCommunicator());
  // A recording says where its cameras stand, a device does not.
  const bool devices = std::none_of(sources.begin(), sources.end(),
                                    [](const std::unique_ptr<io::CameraSource>& source) { return source->hasPoses(); });
  return rigOf(tool, std::move(sources), recording, devices, false);
}

std::unique_ptr<io::FollowingRank> LiveArguments::join(const std::string& tool, const std::vector<std::string>& inputs,
                                                       const io::RecordingOptions& recording, Ranks& ranks) const {
  Sources sources = openSources(tool, inputs, recording, &ranks);
  for (const std::unique_ptr<io::CameraSource>& source : sources) printWarnings(tool, source->warnings());
  auto rank = std::make_unique<io::FollowingRank>(ranks.communicator(), std::move(sources));
  rank->meet(ranks.patientCommunicator());
  return rank;
}

void prepareRecording(const std::string& option, const std::string& path, io::InputFiles inputs) {
  inputs.refuseToReplace(option, path);
  if (std::filesystem::path(path).extension() != ".mcap")
    throw io::OptionError(option + " " + path + ": must end in .mcap");
  io::makeFolderOf(path);
}

void LiveLog::look(io::LiveRig& rig, const std::function<std::string()>& more) {
  for (const std::string& line : rig.takeNotices()) std::cerr << tool_ << ": " << line << std::endl;
  const auto now = std::chrono::steady_clock::now();
  if (every_ <= 0 || std::chrono::duration<double>(now - last_).count() < every_) return;
  last_ = now;
  char seconds[32];
  std::snprintf(seconds, sizeof seconds, "%.0f s", std::chrono::duration<double>(now - start_).count());
  const std::string added = more();
  std::string text = std::string(seconds) + (added.empty() ? "" : ": " + added) + "\n";
  for (const io::CameraStatus& status : rig.status()) text += "  " + io::describe(status) + "\n";
  std::cerr << text << std::flush;
}

std::string LiveLog::summary(const io::LiveRig& rig) {
  std::string text;
  for (const io::CameraStatus& status : rig.status()) {
    char line[256];
    std::snprintf(line, sizeof line, ": %llu views came, %llu were lost before, %llu are in frames, %llu are unused\n",
                  static_cast<unsigned long long>(status.received), static_cast<unsigned long long>(status.lost),
                  static_cast<unsigned long long>(status.used), static_cast<unsigned long long>(status.unused));
    text += "  " + status.name + line;
  }
  return text;
}

}  // namespace fuse_flow::command_line
