// Fuses cameras as they run: into a window, into files, and beside that records them.

#include "calibration/live_extrinsics.h"
#include "command_line/config_file.h"
#include "command_line/live_arguments.h"
#include "command_line/message_of.h"
#include "command_line/method_arguments.h"
#include "command_line/option_checks.h"
#include "command_line/recording_arguments.h"
#include "command_line/threads.h"
#include "command_line/tool.h"
#include "drawing/display.h"
#include "input_checks/input_checks.h"
#include "live/devices.h"
#include "live/rig_recorder.h"
#include "recordings/files/file_io.h"
#include "sinks/background_sink.h"
#include "sinks/cloud_files.h"
#include "sinks/quality_report.h"
#include "viewer/live_frames.h"
#include "viewer/viewer.h"

#include <fuse_flow/recordings/input_files.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <iostream>
#include <memory>
#include <new>
#include <thread>

namespace {

using namespace fuse_flow;
using SteadyClock = std::chrono::steady_clock;

struct Options {
  std::vector<std::string> inputs;
  std::string output;
  std::string format{"ply"};
  std::string report;
  std::string record;
  std::string method;
  std::string config;
  bool window{true};
  bool refine_extrinsics{false};
  bool normals{false};
  viewing::ViewerOptions viewer;
  double status{5};
  io::RecordingOptions recording;
  io::RigRecorder::Options recorder;
  io::MethodOptions method_options;
};

double secondsSince(SteadyClock::time_point start) {
  return std::chrono::duration<double>(SteadyClock::now() - start).count();
}

void warn(const std::vector<std::string>& lines) { command_line::printWarnings("fuse_flow_live", lines); }

/** \brief How long frames took, in milliseconds, in a histogram: an hour of them needs no more memory than a second. */
class Times {
 public:
  void add(double ms) {
    const auto bin = static_cast<std::size_t>(std::clamp(ms / kBin, 0.0, static_cast<double>(bins_.size() - 1)));
    ++bins_[bin];
    ++count_;
  }
  /** \brief \param share 0.5: the median; 0 if there is none */
  double quantile(double share) const {
    std::uint64_t below = 0;
    for (std::size_t bin = 0; bin < bins_.size(); ++bin)
      if (static_cast<double>(below += bins_[bin]) >= share * static_cast<double>(count_) && count_ > 0)
        return kBin * (static_cast<double>(bin) + 0.5);
    return 0;
  }
  std::uint64_t count() const { return count_; }

 private:
  static constexpr double kBin = 0.1;  // ms
  std::vector<std::uint64_t> bins_ = std::vector<std::uint64_t>(100000);
  std::uint64_t count_{0};
};

/** \brief Takes instants from the rig, fuses them where somebody wants clouds, and hands everything on. */
class Pump {
 public:
  Pump(const Options& options, const command_line::LiveArguments& live, io::LiveRig& rig,
       std::vector<std::shared_ptr<io::BackgroundSink>> sinks, std::shared_ptr<viewing::LiveFrames::Inlet> window,
       io::RigRecorder* recorder)
      : options_(options),
        live_(live),
        rig_(rig),
        sinks_(std::move(sinks)),
        window_(std::move(window)),
        recorder_(recorder),
        extrinsics_(options.method_options.device),
        checks_(options.method, options.method_options.parameters, std::vector<bool>(rig.cameras().size(), false)),
        log_("fuse_flow_live", options.status) {
    if (!sinks_.empty() || !window_) method_ = io::makeMethod(options.method, options.method_options);
  }

  /** \brief Until the cameras end, or stop is true. \throws what ends the run */
  void run(const std::atomic<bool>& stop) {
    const SteadyClock::time_point start = SteadyClock::now();
    while (!stop && !io::interrupt_requested && rig_.running() && secondsSince(start) < live_.seconds().value_or(1e12))
      step();
    if (window_) window_->end();
    seconds_ = secondsSince(start);
  }

  std::string summary() const {
    char line[256];
    std::string text;
    const SynchronizerStatistics sets = rig_.statistics();
    std::snprintf(line, sizeof line, "%llu frames in %.1f s, %llu of them without all cameras, up to %.1f ms apart\n",
                  static_cast<unsigned long long>(sets.complete_sets + sets.incomplete_sets), seconds_,
                  static_cast<unsigned long long>(sets.incomplete_sets),
                  1e-3 * static_cast<double>(sets.largest_spread.count()));
    text += line;
    if (fusing_.count() > 0) {
      std::snprintf(line, sizeof line,
                    "  %llu fused, in %.1f ms (median; 95 %%: %.1f); from the last image to the cloud %.1f ms (95 %%: "
                    "%.1f)\n",
                    static_cast<unsigned long long>(fusing_.count()), fusing_.quantile(0.5), fusing_.quantile(0.95),
                    latency_.quantile(0.5), latency_.quantile(0.95));
      text += line;
    }
    return text + command_line::LiveLog::summary(rig_);
  }
  std::vector<std::string> complaints() const { return checks_.complaints(); }
  std::uint64_t fused() const { return fusing_.count(); }

 private:
  void step() {
    const auto instant = std::make_shared<io::LiveInstant>();
    const bool any = rig_.next(std::chrono::milliseconds(100), *instant);
    if (recorder_) recorder_->check();
    if (any) {
      if (window_) window_->put(instant);
      if (method_) fuse(*instant);
    }
    std::string more = std::to_string(fusing_.count()) + " frames fused";
    if (recorder_)
      more += ", " + std::to_string(recorder_->written()) + " views written, " + std::to_string(recorder_->lost()) +
              " lost for want of time";
    log_.look(rig_, method_ || recorder_ ? more : "");
  }

  void fuse(const io::LiveInstant& instant) {
    const std::shared_ptr<io::FusedFrame> frame = pool_.next();
    frame->number = fusing_.count();
    frame->input.rig = instant.rig;
    frame->live = instant.held;
    frame->input.images.assign(instant.held.size(), {});
    if (options_.refine_extrinsics) extrinsics_.place(frame->input.rig);
    for (const CameraMotion& motion : extrinsics_.moved())
      std::cerr << io::describe(motion, frame->input.rig.cameras) << std::endl;
    const bool look = secondsSince(last_look_) > 1;  // it takes time of its own
    if (look) {
      for (std::size_t k = 0; k < instant.held.size(); ++k)
        if (instant.held[k]) frame->input.images[k].assumed_confidence_step = instant.held[k]->assumed_confidence_step;
      checks_.look(frame->input);
      last_look_ = SteadyClock::now();
    }
    const SteadyClock::time_point start = SteadyClock::now();
    try {
      method_->fuse(frame->input.rig, frame->cloud);
    } catch (const pcl::PCLException& error) {
      throw io::InputError("frame " + std::to_string(frame->number) + ": " + io::messageOf(error));
    }
    fusing_.add(1e3 * secondsSince(start));
    latency_.add(1e-3 * static_cast<double>((rig_.now() - instant.arrived).count()));
    frame->has_normals = options_.normals;
    if (options_.normals) frame->with_normals = method_->withNormals();
    frame->statistics = method_->statistics();
    if (look) checks_.lookAt(frame->input.rig, frame->statistics);
    for (const std::shared_ptr<io::BackgroundSink>& sink : sinks_) sink->take(frame);
  }

  const Options& options_;
  const command_line::LiveArguments& live_;
  io::LiveRig& rig_;
  std::vector<std::shared_ptr<io::BackgroundSink>> sinks_;
  std::shared_ptr<viewing::LiveFrames::Inlet> window_;
  io::RigRecorder* recorder_;
  std::unique_ptr<io::Method> method_;
  io::LiveExtrinsics extrinsics_;
  io::InputChecks checks_;
  io::FramePool pool_;
  command_line::LiveLog log_;
  SteadyClock::time_point last_look_;
  Times fusing_, latency_;
  double seconds_{0};
};

/** \brief The window in this thread, which it needs, and the pump in another one. \throws what ended the pump */
void runWithWindow(const Options& options, const io::LiveRig& rig, Pump& pump,
                   const std::shared_ptr<viewing::LiveFrames::Inlet>& inlet) {
  viewing::ViewerOptions viewer_options = options.viewer;
  viewer_options.method = options.method;
  viewer_options.method_options = options.method_options;
  viewer_options.refine_extrinsics = options.refine_extrinsics;
  viewer_options.measure = false;  // it takes longer than fusing
  std::atomic<bool> stop{false}, ended{false};
  std::exception_ptr error;
  std::thread pumping([&] {
    try {
      pump.run(stop);
    } catch (...) {
      error = std::current_exception();
      inlet->end();
    }
    ended = true;
  });
  {
    const std::size_t cameras = rig.cameras().size();
    auto source = std::make_unique<viewing::LiveFrames>(rig, std::to_string(cameras) + " cameras", inlet);
    viewing::Viewer viewer(std::move(source), viewer_options);
    viewer.run([&] { return ended.load(); });
    stop = true;
    inlet->end();  // the viewer's thread waits for no more
  }
  pumping.join();
  if (error) std::rethrow_exception(error);
}

void checkOutputs(const Options& options, const io::LiveRig& rig) {
  namespace fs = std::filesystem;
  io::InputFiles inputs(rig.inputs());
  inputs.add(options.config);
  if (!options.output.empty()) {
    const std::string extension = fs::path(options.output).extension().string();
    const bool is_file = fs::exists(options.output) && !fs::is_directory(options.output);
    if (extension == ".ply" || extension == ".pcd" || is_file)
      throw io::OptionError("-o " + options.output + ": must be a folder, for a cloud a frame");
    const io::CloudFiles files(options.output, options.format, 2);
    inputs.refuseToReplace("-o", files.pathOf(0));
    if (fs::exists(options.output) && !fs::is_empty(options.output))
      throw io::OptionError("-o " + options.output + ": holds files already, must be a new folder, or an empty one");
  }
  if (!options.report.empty()) inputs.refuseToReplace("--report", options.report);
  if (fs::is_directory(options.report))
    throw io::OptionError("--report " + options.report + ": is a folder, must be a file");
  std::error_code error;
  const auto whole = [&](const std::string& path) { return fs::weakly_canonical(fs::absolute(path, error), error); };
  if (!options.report.empty() && !options.record.empty() && whole(options.report) == whole(options.record))
    throw io::OptionError("--report " + options.report + ": the recording goes to this file, must be another");
  if (!options.record.empty()) command_line::prepareRecording("--record", options.record, inputs);
}

void requireDisplay() {
  try {
    drawing::requireDisplay("fuse_flow_live");
  } catch (const io::InputError& error) {
    throw io::InputError(std::string(error.what()) + ", or with --no-window");
  }
}

int run(const Options& options, const command_line::LiveArguments& live) {
  if (options.window) requireDisplay();
  const std::unique_ptr<io::LiveRig> rig = live.open("fuse_flow_live", options.inputs, options.recording, false);
  checkOutputs(options, *rig);
  std::vector<std::string> names;
  for (const Camera& camera : rig->cameras()) names.push_back(camera.name);
  std::vector<std::shared_ptr<io::BackgroundSink>> sinks;
  const auto add = [&](std::shared_ptr<io::FrameSink> sink) {
    constexpr std::size_t waiting = 8;  // frames
    sinks.push_back(std::make_shared<io::BackgroundSink>(std::move(sink), waiting, io::BackgroundSink::WhenFull::Drop));
  };
  if (!options.output.empty()) add(std::make_shared<io::CloudFiles>(options.output, options.format, 2, true));
  std::shared_ptr<io::QualityReport> report;
  if (!options.report.empty()) {
    io::QualityReport::Options report_options;
    report_options.measure = false;
    report_options.file = options.report;
    add(report = std::make_shared<io::QualityReport>(options.method, names, report_options));
  }
  std::unique_ptr<io::RigRecorder> recorder;
  if (!options.record.empty()) {
    recorder = std::make_unique<io::RigRecorder>(options.record, *rig, options.recorder);
    warn(recorder->warnings());
  }
  if (!options.window && sinks.empty()) warn({"the clouds go nowhere, and only take time: -o writes them"});
  const auto inlet = options.window ? std::make_shared<viewing::LiveFrames::Inlet>() : nullptr;
  Pump pump(options, live, *rig, sinks, inlet, recorder.get());
  io::catchInterrupts();
  rig->start();
  if (options.window) {
    runWithWindow(options, *rig, pump, inlet);
  } else {
    pump.run(false);
  }
  rig->stop();
  if (recorder) {
    recorder->finish();
    warn(recorder->leftOut());
  }
  if (report) {
    nlohmann::json cameras = nlohmann::json::array();
    for (const io::CameraStatus& status : rig->status())
      cameras.push_back({{"name", status.name},
                         {"views", status.received},
                         {"lost", status.lost},
                         {"used", status.used},
                         {"unused", status.unused}});
    report->note("cameras_that_ran", std::move(cameras));
  }
  std::cout << pump.summary();
  if (recorder)
    std::printf("  %s: %llu views, %.1f MB\n", options.record.c_str(),
                static_cast<unsigned long long>(recorder->written()), static_cast<double>(recorder->bytes()) * 1e-6);
  std::vector<std::string> noticed = pump.complaints();
  if (rig->statistics().complete_sets + rig->statistics().incomplete_sets == 0)
    noticed.push_back("no image came, and nothing was fused");
  for (const std::shared_ptr<io::BackgroundSink>& sink : sinks) {
    for (std::string& line : sink->finish()) noticed.push_back(std::move(line));
    if (sink->dropped() > 0)
      noticed.push_back(std::to_string(sink->dropped()) + " of " + std::to_string(pump.fused()) +
                        " clouds were not written: they came faster than the disk took them");
  }
  if (recorder && recorder->lost() > 0)
    noticed.push_back(std::to_string(recorder->lost()) + " views are not in " + options.record +
                      ": they came faster than they could be compressed and written");
  for (const std::string& line : noticed) std::cout << "  " << line << "\n";
  std::cout << std::flush;
  return command_line::kSuccess;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  bool list = false;
  CLI::App app(
      "Fuses cameras as they run, or a recording that is played as if its cameras ran: into a window, into files, and "
      "beside that records them.",
      "fuse_flow_live");
  command_line::RecordingArguments recording(app);
  app.add_flag("--list", list, "say which devices are connected, and end");
  app.add_option("-o,--output", options.output,
                 "a new folder: the cloud of each frame, and timestamps.txt with their times")
      ->check(command_line::path());
  app.add_option("--format", options.format, "of these files")
      ->check(CLI::IsMember({"ply", "pcd"}))
      ->capture_default_str();
  app.add_flag("--normals", options.normals, "write the surface's normal with each point, facing its cameras");
  app.add_option("--report", options.report,
                 "write times and counts of each frame, and of the cameras, to this JSON file")
      ->check(command_line::path());
  app.add_option("--record", options.record,
                 "write what the cameras deliver to this .mcap file, as fuse_flow_record does")
      ->check(command_line::path());
  app.add_option("--color-quality", options.recorder.messages.color_quality,
                 "of colour in that file, by JPEG, 1-100; depth loses nothing")
      ->check(command_line::wholeNumber(1, 100))
      ->capture_default_str();
  app.add_flag("!--no-window", options.window, "show nothing");
  app.add_option("--width", options.viewer.width, "of the window, pixels")
      ->check(command_line::wholeNumber(16, 16384))
      ->capture_default_str();
  app.add_option("--height", options.viewer.height, "pixels")
      ->check(command_line::wholeNumber(16, 16384))
      ->capture_default_str();
  app.add_option("--folder", options.viewer.folder, "where the window's keys Ctrl w, j and Ctrl p write")
      ->check(command_line::path())
      ->capture_default_str();
  app.add_flag("--refine-extrinsics", options.refine_extrinsics,
               "estimate the poses from what the cameras see, and follow them from frame to frame");
  app.add_option("--status", options.status, "seconds between two reports of how the cameras do; 0: none")
      ->check(command_line::nonNegativeNumber())
      ->capture_default_str();
  command_line::LiveArguments live(app);
  command_line::MethodArguments method(app);
  return command_line::runTool(app, argc, argv, [&] {
    if (list) {
      for (const std::string& line : io::listDevices()) std::cout << line << "\n";
      return static_cast<int>(command_line::kSuccess);
    }
    options.inputs = recording.inputs();
    if (options.inputs.empty())
      throw io::OptionError("input: must be given: devices (--list says which there are), or a recording to play");
    options.recording = recording.options();
    options.method = method.method();
    options.method_options = method.options();
    options.method_options.normals = options.normals;
    options.config = command_line::configFileOf(app);
    command_line::requireThreads(options.method_options.threads);
    return run(options, live);
  });
}
