// Fuses cameras as they run, or a recording that is played again and again, and streams the clouds to browsers and other programs.

#include "command_line/arguments/live_arguments.h"
#include "command_line/arguments/method_arguments.h"
#include "command_line/arguments/option_checks.h"
#include "command_line/arguments/recording_arguments.h"
#include "command_line/arguments/stereo_arguments.h"
#include "command_line/arguments/stream_arguments.h"
#include "command_line/config_file.h"
#include "command_line/live_pump.h"
#include "command_line/ranks.h"
#include "command_line/threads.h"
#include "command_line/tool.h"
#include "recordings/files/file_io.h"
#include "recordings/files/interrupt.h"
#include "sinks/stream_sink.h"

#include <fuse_flow/stream/stream_file.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <thread>

namespace {

using namespace fuse_flow;

constexpr const char* kTool = "fuse_flow_serve";

struct Options {
  std::vector<std::string> inputs;
  std::string method;
  std::string name;
  bool refine_extrinsics{false};
  bool normals{false};
  double status{5};
  command_line::Ranks* ranks{nullptr};  ///< null: this process alone
  io::RankShare share;                  ///< of this rank
  io::RecordingOptions recording;
  io::MethodOptions method_options;
  io::StereoOptions stereo;  ///< of cameras without depth
};

void warn(const std::vector<std::string>& lines) { command_line::printWarnings(kTool, lines); }

/** \brief The last part of a path, "recording" of "build/demo/recording/". */
std::string nameOf(const std::vector<std::string>& inputs) {
  if (inputs.size() != 1) return std::to_string(inputs.size()) + " inputs";
  const std::filesystem::path path(inputs[0]);
  return (path.has_filename() ? path : path.parent_path()).filename().string();
}

/** \brief Fuses what cameras deliver. */
int serve(const Options& options, const command_line::LiveArguments& live,
          const command_line::StreamArguments& arguments) {
  std::optional<io::LeadingRank> leader;
  if (options.ranks != nullptr) leader.emplace(options.ranks->communicator());
  const std::unique_ptr<io::LiveRig> rig =
      leader ? live.open(kTool, options.inputs, options.recording, *leader, *options.ranks)
             : live.open(kTool, options.inputs, options.recording, false);
  const std::unique_ptr<io::ViewStereo> stereo = command_line::stereoOf(kTool, *rig, options.stereo);
  if (stereo && options.refine_extrinsics)
    throw io::OptionError("--refine-extrinsics: follows depth that cameras measure, and some of these measure none");
  const std::shared_ptr<stream::Server> server = arguments.open(options.method);
  stream::Description description;
  description.name = options.name;
  description.step = arguments.step();
  description.cameras = rig->cameras();
  server->describe(description);
  const auto sink = std::make_shared<io::BackgroundSink>(
      std::make_shared<io::StreamSink>(server, description, arguments.images()), 1, io::BackgroundSink::WhenFull::Drop);
  command_line::LivePump::Options pump_options;
  pump_options.stereo = stereo.get();
  pump_options.tool = kTool;
  pump_options.method = options.method;
  pump_options.method_options = options.method_options;
  pump_options.refine_extrinsics = options.refine_extrinsics;
  pump_options.status = options.status;
  pump_options.seconds = live.seconds();
  pump_options.leader = leader ? &*leader : nullptr;
  pump_options.share = options.share;
  command_line::StreamLog log;
  pump_options.more = [&] { return log.describe(server->status()); };
  pump_options.tick = [&] { warn(server->takeNotices()); };
  command_line::LivePump pump(pump_options, *rig, {sink});
  io::catchInterrupts();
  if (leader) leader->begin(rig->cameras(), options.ranks->patientCommunicator());
  rig->start();
  if (leader) leader->awaitOthers(options.ranks->patientCommunicator());
  command_line::printLink(kTool, *server);
  pump.run(false);
  rig->stop();
  std::cout << pump.summary();
  std::vector<std::string> noticed = pump.complaints();
  for (std::string& line : sink->finish()) noticed.push_back(std::move(line));
  if (sink->dropped() > 0)
    noticed.push_back(std::to_string(sink->dropped()) + " of " + std::to_string(pump.fused()) +
                      " clouds were not streamed: they came faster than they could be encoded");
  for (const std::string& line : noticed) std::cout << "  " << line << "\n";
  std::cout << std::flush;
  return command_line::kSuccess;
}

/** \brief Options that were given, and that a stream that was kept does not ask for: its frames are sent as they are. */
std::vector<std::string> withoutEffectOnStreams(const CLI::App& app) {
  return command_line::givenBut(
      app, {"input", "--port", "--address", "--token-file", "--certificate", "--key", "--allow-origin", "--allow-host",
            "--clients", "--seconds", "--speed", "--once", "--config"});
}

/** \brief Plays a stream that was kept. */
int replay(const Options& options, const CLI::App& app, const command_line::LiveArguments& live,
           const command_line::StreamArguments& arguments) {
  using Clock = std::chrono::steady_clock;
  for (const std::string& option : withoutEffectOnStreams(app))
    warn({option + " has no effect on a stream that was kept: its clouds are sent as they are"});
  stream::StreamReader reader(options.inputs[0]);
  if (reader.frames() == 0) throw io::InputError(options.inputs[0] + ": has no frame");
  if (reader.cutOff()) warn({options.inputs[0] + ": was cut off; what is before that is played"});
  const std::shared_ptr<stream::Server> server = arguments.open(options.method);
  io::catchInterrupts();
  command_line::printLink(kTool, *server);
  const Clock::time_point start = Clock::now();
  const auto over = [&] {
    return io::interrupt_requested ||
           std::chrono::duration<double>(Clock::now() - start).count() >= live.seconds().value_or(1e12);
  };
  std::uint64_t number = 0;
  Clock::time_point due = start;
  std::vector<std::uint8_t> message;
  std::string described;
  do {
    for (std::size_t k = 0; k < reader.frames() && !over(); ++k, ++number) {
      reader.read(k, message);
      if (std::string json = stream::toJson(reader.description()); json != described) {
        server->describe(reader.description());
        described = std::move(json);
      }
      const auto frame = std::make_shared<stream::EncodedFrame>(*stream::frameOf(message.data(), message.size()));
      frame->times.number = number;
      frame->times.captured = 0;  // long ago
      frame->times.encoded =
          std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
              .count();
      server->publish(frame);
      warn(server->takeNotices());
      // As far apart as they were; what was paused for longer than a few seconds is not waited for, nor what goes back.
      std::int64_t gap = 33'000'000;
      if (k + 1 < reader.frames()) gap = reader.time(k + 1) - reader.time(k);
      const auto apart = static_cast<double>(std::clamp<std::int64_t>(gap, 1'000'000, 5'000'000'000));
      due += std::chrono::nanoseconds(static_cast<std::int64_t>(apart / live.speed()));
      while (Clock::now() < due && !over())
        std::this_thread::sleep_for(std::min<Clock::duration>(due - Clock::now(), std::chrono::milliseconds(50)));
    }
  } while (live.loops() && !over());
  std::cout << number << " frames" << std::endl;
  return command_line::kSuccess;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app(
      "Fuses cameras as they run, or a recording that is played as if its cameras ran, and streams the clouds: to the "
      "page that it shows in browsers, to fuse_flow_receive and fuse_flow_viewer, and to programs of yours. It prints "
      "a link. A stream that was kept, a .ffs file, is streamed as it is.",
      kTool);
  command_line::RecordingArguments recording(app);
  command_line::StreamArguments stream(app);
  app.add_option("--name", options.name, "of the stream, for people; default: the input's");
  app.add_flag("--normals", options.normals, "stream the surface's normal with each point");
  app.add_flag("--refine-extrinsics", options.refine_extrinsics,
               "estimate the poses from what the cameras see, and follow them from frame to frame");
  app.add_option("--status", options.status, "seconds between two reports of how cameras and clients do; 0: none")
      ->check(command_line::nonNegativeNumber())
      ->capture_default_str();
  command_line::LiveArguments live(app, true);
  command_line::MethodArguments method(app);
  command_line::StereoArguments stereo(app);
  const command_line::RankShareArguments rank_share(app);
  return command_line::runTool(app, argc, argv, [&] {
    const std::unique_ptr<command_line::Ranks> ranks = command_line::Ranks::ofThisRun();
    options.ranks = ranks.get();
    const auto is_stream = [](const std::string& input) { return std::filesystem::path(input).extension() == ".ffs"; };
    const auto run = [&] {
      options.inputs = recording.inputs();
      if (options.inputs.empty() && !ranks)
        throw io::OptionError("input: must be given: a recording, devices, or a stream that was kept");
      if (options.name.empty()) options.name = nameOf(options.inputs);
      options.recording = recording.options();
      options.method = method.method();
      options.method_options = method.options();
      if (!ranks || ranks->isFirst()) warn(method.advice());
      if (!ranks) warn(rank_share.advice(false));
      options.method_options.normals = options.normals;
      command_line::requireThreads(options.method_options.threads);
      options.stereo = command_line::stereoOfLive(kTool, stereo, ranks != nullptr, method, options.method_options);
      if (std::any_of(options.inputs.begin(), options.inputs.end(), is_stream)) {
        if (options.inputs.size() > 1)
          throw io::OptionError("input: must be one stream file, or a recording, or devices");
        if (ranks) throw io::OptionError("input: a stream that was kept is served by one process, not under mpirun");
        return replay(options, app, live, stream);
      }
      if (!ranks) return serve(options, live, stream);
      command_line::requireOfLiveRanks(options.method, options.method_options);
      options.share = rank_share.of(ranks->rank());
      if (ranks->isFirst()) return serve(options, live, stream);
      command_line::followLiveRank(kTool, *ranks, live, options.inputs, options.recording, options.method_options,
                                   options.share, options.refine_extrinsics);
      return static_cast<int>(command_line::kSuccess);
    };
    return ranks ? ranks->guard(kTool, run, command_line::Ranks::Commands::Own) : run();
  });
}
