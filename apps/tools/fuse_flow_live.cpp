// Fuses cameras as they run: into a window, into files, and beside that records them.

#include "command_line/arguments/live_arguments.h"
#include "command_line/arguments/method_arguments.h"
#include "command_line/arguments/option_checks.h"
#include "command_line/arguments/recording_arguments.h"
#include "command_line/arguments/stereo_arguments.h"
#include "command_line/config_file.h"
#include "command_line/live_pump.h"
#include "command_line/ranks.h"
#ifdef FUSE_FLOW_WITH_STREAM
#include "command_line/arguments/stream_arguments.h"
#include "sinks/stream_sink.h"
#endif
#include "command_line/threads.h"
#include "command_line/tool.h"
#include "drawing/display.h"
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
  bool camera_mask{false};
  bool serve{false};
  command_line::Ranks* ranks{nullptr};  ///< null: this process alone
  io::RankShare share;                  ///< of this rank
  viewing::ViewerOptions viewer;
  double status{5};
  io::RecordingOptions recording;
  io::RigRecorder::Options recorder;
  io::MethodOptions method_options;
  io::StereoOptions stereo;  ///< of cameras without depth
};

void warn(const std::vector<std::string>& lines) { command_line::printWarnings("fuse_flow_live", lines); }

/** \brief The window in this thread, which it needs, and the pump in another one. \throws what ended the pump */
void runWithWindow(const Options& options, const io::LiveRig& rig, command_line::LivePump& pump,
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
      inlet->end();
    } catch (...) {
      error = std::current_exception();
      inlet->end();
    }
    ended = true;
  });
  std::exception_ptr of_window;
  try {
    const std::size_t cameras = rig.cameras().size();
    auto source = std::make_unique<viewing::LiveFrames>(rig, std::to_string(cameras) + " cameras", inlet);
    viewing::Viewer viewer(std::move(source), viewer_options);
    viewer.run([&] { return ended.load(); });
    stop = true;
    inlet->end();  // the viewer's thread waits for no more
  } catch (...) {  // the pump still runs
    of_window = std::current_exception();
    stop = true;
    inlet->end();
  }
  pumping.join();
  if (of_window) std::rethrow_exception(of_window);
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

#ifdef FUSE_FLOW_WITH_STREAM
using command_line::StreamArguments;
#else
/** \brief Of a build without Boost, OpenSSL or Zstandard. */
struct StreamArguments {
  explicit StreamArguments(CLI::App&) {}
};
#endif

int run(const Options& options, const command_line::LiveArguments& live, const StreamArguments& stream) {
#ifndef FUSE_FLOW_WITH_STREAM
  (void)stream;
  if (options.serve)
    throw io::OptionError("--serve: this fuse_flow_live was built without Boost, OpenSSL or Zstandard");
#endif

  if (options.window) requireDisplay();
  std::optional<io::LeadingRank> leader;
  if (options.ranks != nullptr) leader.emplace(options.ranks->communicator());
  const std::unique_ptr<io::LiveRig> rig =
      leader ? live.open("fuse_flow_live", options.inputs, options.recording, *leader, *options.ranks)
             : live.open("fuse_flow_live", options.inputs, options.recording, false);
  const std::unique_ptr<io::ViewStereo> stereo = command_line::stereoOf("fuse_flow_live", *rig, options.stereo);
  if (stereo && options.refine_extrinsics)
    throw io::OptionError("--refine-extrinsics: follows depth that cameras measure, and some of these measure none");
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
#ifdef FUSE_FLOW_WITH_STREAM
  std::shared_ptr<stream::Server> server;
  command_line::StreamLog stream_log;
  if (options.serve) {
    server = stream.open(options.method);
    stream::Description description;
    description.name = "fuse_flow_live";
    description.step = stream.step();
    description.cameras = rig->cameras();
    server->describe(description);
    // One cloud waits: who looks at a stream wants the newest.
    sinks.push_back(std::make_shared<io::BackgroundSink>(
        std::make_shared<io::StreamSink>(server, description, stream.images()), 1, io::BackgroundSink::WhenFull::Drop));
    command_line::printLink("fuse_flow_live", *server);
  }
#endif
  if (!options.window && sinks.empty()) warn({"the clouds go nowhere, and only take time: -o writes them"});
  if (const std::string line = command_line::cameraMaskAdvice(options.camera_mask, rig->cameras().size());
      !line.empty())
    warn({line});
  if (options.camera_mask && options.output.empty()) warn({"--camera-mask has no effect without -o"});
  const auto inlet = options.window ? std::make_shared<viewing::LiveFrames::Inlet>() : nullptr;
  command_line::LivePump::Options pump_options;
  pump_options.stereo = stereo.get();
  pump_options.tool = "fuse_flow_live";
  pump_options.method = options.method;
  pump_options.method_options = options.method_options;
  pump_options.refine_extrinsics = options.refine_extrinsics;
  pump_options.status = options.status;
  pump_options.seconds = live.seconds();
  pump_options.leader = leader ? &*leader : nullptr;
  pump_options.share = options.share;
  if (inlet) pump_options.instant = [inlet](const auto& instant) { inlet->put(instant); };
  pump_options.recorder = recorder.get();
#ifdef FUSE_FLOW_WITH_STREAM
  if (server) {
    pump_options.more = [&] { return stream_log.describe(server->status()); };
    pump_options.tick = [&] { warn(server->takeNotices()); };
  }
#endif
  command_line::LivePump pump(pump_options, *rig, sinks);
  io::catchInterrupts();
  if (leader) leader->begin(rig->cameras(), options.ranks->patientCommunicator());
  rig->start();
  if (leader) leader->awaitOthers(options.ranks->patientCommunicator());
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
      noticed.push_back(
          std::to_string(sink->dropped()) + " of " + std::to_string(pump.fused()) +
          " clouds were not written or streamed: they came faster than the disk or the encoder took them");
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
  command_line::addCameraMaskOption(app, options.camera_mask);
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
  app.add_flag("--serve", options.serve, "stream the clouds, as fuse_flow_serve does, and print the link");
  StreamArguments stream(app);
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
  command_line::StereoArguments stereo(app);
  const command_line::RankShareArguments rank_share(app);
  return command_line::runTool(app, argc, argv, [&] {
    if (list) {
      for (const std::string& line : io::listDevices()) std::cout << line << "\n";
      return static_cast<int>(command_line::kSuccess);
    }
    const std::unique_ptr<command_line::Ranks> ranks = command_line::Ranks::ofThisRun();
    options.ranks = ranks.get();
    const auto runRank = [&] {
      options.inputs = recording.inputs();
      if (options.inputs.empty() && !ranks)
        throw io::OptionError("input: must be given: devices (--list says which there are), or a recording to play");
      options.recording = recording.options();
      options.method = method.method();
      options.method_options = method.options();
      if (!ranks || ranks->isFirst()) warn(method.advice());
      if (!ranks) warn(rank_share.advice(false));
      options.method_options.normals = options.normals;
      options.method_options.camera_mask = options.camera_mask;
      options.config = command_line::configFileOf(app);
      command_line::requireThreads(options.method_options.threads);
      options.stereo =
          command_line::stereoOfLive("fuse_flow_live", stereo, ranks != nullptr, method, options.method_options);
      if (!ranks) return run(options, live, stream);
      command_line::requireOfLiveRanks(options.method, options.method_options);
      if (options.window)
        throw io::OptionError(
            "the window: no rank has the images of all cameras; must be --no-window, and --serve shows the clouds in a "
            "browser");
      if (!options.record.empty())
        throw io::OptionError("--record: no rank has the images of all cameras; fuse_flow_record writes those of each");
      options.share = rank_share.of(ranks->rank());
      if (ranks->isFirst()) return run(options, live, stream);
      command_line::followLiveRank("fuse_flow_live", *ranks, live, options.inputs, options.recording,
                                   options.method_options, options.share, options.refine_extrinsics);
      return static_cast<int>(command_line::kSuccess);
    };
    return ranks ? ranks->guard("fuse_flow_live", runRank, command_line::Ranks::Commands::Own) : runRank();
  });
}
