// Fuses a recording of several depth cameras, frame by frame.

#include "calibration/shared_poses.h"
#include "clouds/plain_clouds.h"
#include "command_line/arguments/method_arguments.h"
#include "command_line/arguments/option_checks.h"
#include "command_line/arguments/quality_options.h"
#include "command_line/arguments/recording_arguments.h"
#include "command_line/arguments/stereo_arguments.h"
#include "command_line/config_file.h"
#include "command_line/message_of.h"
#include "command_line/ranks.h"
#include "command_line/threads.h"
#include "command_line/tool.h"
#include "input_checks/empty_clouds.h"
#include "input_checks/estimated_depth.h"
#include "input_checks/input_checks.h"
#include "methods/distributed_fusion.h"
#include "methods/plain_fusion.h"
#include "recordings/range.h"
#include "recordings/read_ahead.h"
#include "recordings/still_there.h"
#include "sinks/background_sink.h"
#include "sinks/cloud_files.h"
#include "sinks/frame_sink.h"
#include "sinks/quality_report.h"

#include <fuse_flow/distributed/message.h>
#include <fuse_flow/impl/host/parallel.hpp>
#include <fuse_flow/recordings/input_files.h>

#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <new>
#include <optional>
#include <set>

namespace {

using namespace fuse_flow;
namespace fs = std::filesystem;

struct Options {
  std::vector<std::string> inputs;
  std::string output;
  std::string report;
  std::string method;
  std::string frames;
  std::string format{"ply"};
  bool evaluate{true};
  ReprojectionQualityParameters quality;
  bool refine_extrinsics{false};
  bool normals{false};
  bool camera_mask{false};
  bool overlap{true};
  bool resume{false};
  std::string config;
  io::RecordingOptions recording;
  io::StereoOptions stereo;
  io::MethodOptions method_options;
  command_line::Ranks* ranks{nullptr};  ///< null: this process alone
  bool share_frames{false};
  io::RankShare share;  ///< of this rank, where they share cameras

  /** \brief Whether the ranks have some cameras each. */
  bool sharesCameras() const { return ranks != nullptr && !share_frames; }
  /** \brief Whether this process gets clouds, to write them. */
  bool writes() const { return !sharesCameras() || ranks->isFirst(); }
};

/** \brief Neither may take the place of an input, nor the report that of a cloud. */
void checkOutputs(const Options& options, const io::Recording& recording, const io::CloudFiles& files,
                  const std::vector<std::size_t>& frames) {
  io::InputFiles inputs(recording.inputs());
  inputs.add(options.config);
  std::error_code error;
  const auto whole = [&](const std::string& path) { return fs::weakly_canonical(fs::absolute(path, error), error); };
  const fs::path report = whole(options.report);
  for (const std::size_t frame : frames) {
    const std::string cloud = files.pathOf(frame);
    inputs.refuseToReplace("-o", cloud);
    if (!options.report.empty() && whole(cloud) == report)
      throw io::OptionError("--report " + options.report + ": a cloud goes to this file, must be another");
  }
  if (!options.report.empty()) inputs.refuseToReplace("--report", options.report);
  if (fs::is_directory(options.report, error))
    throw io::OptionError("--report " + options.report + ": is a folder, must be a file");
}

/** \brief What the library says, and what would be right. */
std::string whyNotFused(const pcl::PCLException& error) {
  const std::string message = io::messageOf(error);
  if (message.find(" cells of ") != std::string::npos)
    return message + "; must be nearer (--max-range) or the cells larger (--cell-size)";
  if (message.find("ConfidenceForm::Given") != std::string::npos)
    return message + "; --confidence-form given needs confidence images of every camera";
  if (message.find("agreement.min_views") != std::string::npos)
    return message + "; that is --min-agreeing-views, 2 with --depth-source stereo or network";
  return message;
}

double seconds(std::chrono::steady_clock::time_point since) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - since).count();
}

/** \brief What fusion took is longer where it had no core for itself. */
std::string sideBySide(std::size_t frames, double seconds) {
  char line[200];
  std::snprintf(
      line, sizeof line,
      "  %zu frames in %.1f s: what reads, writes and measures shares the cores with what fuses; --no-overlap "
      "times fusion alone",
      frames, seconds);
  return line;
}

/** \brief Frames done, rate, time left; on a terminal only, so that logs stay readable. */
class Progress {
 public:
  explicit Progress(std::size_t count) : count_(count) {}
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress() { endLine(); }

  void show(std::size_t done) {
    if (!isatty(STDERR_FILENO)) return;
    const double rate = static_cast<double>(done) / seconds(start_);
    std::fprintf(stderr, "\r%zu of %zu frames, %.1f frames/s with reading, writing and measuring, %.0f s left   ", done,
                 count_, rate, static_cast<double>(count_ - done) / rate);
    in_line_ = true;
  }
  /** \brief What is printed next begins a line. */
  void endLine() {
    if (in_line_) std::fputc('\n', stderr);
    in_line_ = false;
  }

 private:
  std::size_t count_;
  std::chrono::steady_clock::time_point start_{std::chrono::steady_clock::now()};
  bool in_line_{false};
};

/** \brief The frames of a recording, one after the other, or some of them ahead. */
class Frames {
 public:
  Frames(io::Recording& recording, const std::vector<std::size_t>& frames, bool ahead, int threads)
      : recording_(recording) {
    if (ahead) ahead_.emplace(recording, frames, threads > 4 ? 4 : 2);  // beyond what cores decode side by side
  }
  void next(std::size_t number, io::LoadedFrame& frame) {
    if (ahead_)
      ahead_->next(frame);
    else
      recording_.read(number, frame);
  }
  /** \brief Nothing reads any more. */
  void end() { ahead_.reset(); }

 private:
  io::Recording& recording_;
  std::optional<io::ReadAhead> ahead_;
};

/** \brief What takes the fused frames, one after the other, or each on a thread of its own. */
class Sinks {
 public:
  Sinks(std::vector<std::shared_ptr<io::FrameSink>> sinks, bool background) : sinks_(std::move(sinks)) {
    constexpr std::size_t waiting = 2;  // frames
    for (std::shared_ptr<io::FrameSink>& sink : sinks_) {
      if (!background) continue;
      background_.push_back(std::make_shared<io::BackgroundSink>(std::move(sink), waiting));
      sink = background_.back();
    }
  }
  void take(const std::shared_ptr<const io::FusedFrame>& frame) {
    for (const std::shared_ptr<io::FrameSink>& sink : sinks_) sink->take(frame);
  }
  /** \brief Waits for what was taken. \throws what went wrong with it, which was earlier than what goes wrong now */
  void drain() {
    for (const std::shared_ptr<io::BackgroundSink>& sink : background_) sink->drain();
  }
  /** \brief What was noticed, a line each. */
  std::vector<std::string> finish() {
    std::vector<std::string> noticed;
    for (const std::shared_ptr<io::FrameSink>& sink : sinks_)
      for (std::string& line : sink->finish()) noticed.push_back(std::move(line));
    return noticed;
  }

 private:
  std::vector<std::shared_ptr<io::FrameSink>> sinks_;
  std::vector<std::shared_ptr<io::BackgroundSink>> background_;
};

/** \brief Of each camera that has such, how many; null if none has. */
nlohmann::json imagesWithoutPartner(const io::Recording& recording) {
  nlohmann::json counts;
  for (std::size_t k = 0; k < recording.cameras().size(); ++k)
    if (const std::size_t count = recording.imagesWithoutPartner(k); count > 0)
      counts[recording.cameras()[k].name] = count;
  return counts;
}

void warnOf(const std::string& line) {
  if (!line.empty()) command_line::printWarnings("fuse_flow_fuse", {line});
}

io::QualityReport::Options reportOptions(const Options& options) {
  io::QualityReport::Options result;
  result.measure = options.evaluate;
  result.threads = options.method_options.threads;
  result.file = options.report;
  result.reprojection = options.quality;
  const PreprocessingParameters& range = options.method_options.parameters.preprocessing;
  result.reprojection.min_range = range.min_range;
  result.reprojection.max_range = range.max_range;
  result.surface = command_line::surfaceParameters(result.reprojection);
  return result;
}

io::MethodOptions methodOptions(const Options& options, const command_line::MethodArguments& arguments) {
  io::MethodOptions result = arguments.options();
  result.normals = options.normals;
  result.camera_mask = options.camera_mask;
  return result;
}

/** \brief Options that were given, and that the spatial hash alone does not ask for. */
std::vector<std::string> withoutEffectOnClouds(const CLI::App& app) {
  static const std::set<std::string> with_effect{
      "input",       "--output",        "--report",          "--frames",     "--format",
      "--normals",   "--camera-mask",   "--poses",           "--config",     "--method",
      "--resume",    "--threads",       "--device",          "--no-quality", "--no-overlap",
      "--cell-size", "--min-cell-size", "--points-per-cell", "--min-weight", "--weak-weight"};
  return command_line::givenBut(app, with_effect);
}

/** \brief What is odd about a cloud that was fused, a line; empty: nothing. */
std::string oddCloud(std::size_t points, std::size_t fused) {
  if (points == 0 || fused * 100 < points * 98) return "";
  return "hardly any two points are in one cell, so that nothing was fused: the clouds must be in metres, and the "
         "cells "
         "(--min-cell-size) as large as the distance of the scanners' points";
}

/** \brief Of \p frames those whose cloud is not there yet. */
std::vector<std::size_t> withoutCloud(const Options& options, const io::CloudFiles& files,
                                      const std::vector<std::size_t>& frames) {
  // A pipe is no cloud of before, and an empty file none that was finished.
  const auto is_there = [&](std::size_t frame) {
    std::error_code error;
    const std::string path = files.pathOf(frame);
    return fs::is_regular_file(path, error) && fs::file_size(path, error) > 0;
  };
  std::vector<std::size_t> missing;
  std::copy_if(frames.begin(), frames.end(), std::back_inserter(missing), [&](std::size_t k) { return !is_there(k); });
  const std::string rank =
      options.ranks && options.share_frames ? "rank " + std::to_string(options.ranks->rank()) + ": " : "";
  if (const std::size_t there = frames.size() - missing.size(); there > 0)
    warnOf(rank + "--resume: " + std::to_string(there) + " of " + std::to_string(frames.size()) +
           " clouds are there and stay as they are; of other options they would be others" +
           (missing.empty()          ? "; nothing is left to do"
            : options.report.empty() ? ""
                                     : "; --report tells of the rest"));
  return missing;
}

/** \brief The first rank's \p missing at all ranks: the others may have another disk. \param frames of the recording, as this rank has it */
std::vector<std::size_t> asTheFirstRank(const Options& options, const std::vector<std::size_t>& missing,
                                        const std::vector<std::size_t>& frames) {
  distributed::Communicator& ranks = options.ranks->communicator();
  // "RFFF": of a rank that does not resume there comes something else, which does not begin so.
  constexpr std::uint32_t magic = 0x46464652;
  distributed::Message message;
  distributed::MessageWriter writer(message);
  writer.put(magic);
  writer.put(static_cast<std::uint64_t>(missing.size()));
  writer.put(missing.data(), missing.size());
  std::vector<distributed::Communicator::Outgoing> out;
  if (options.ranks->isFirst())
    for (const int rank : distributed::otherRanks(ranks)) out.push_back({rank, message.data(), message.size()});
  std::vector<distributed::Message> in;
  ranks.exchange(out, options.ranks->isFirst() ? std::vector<int>() : std::vector<int>{0}, in);
  if (options.ranks->isFirst()) return missing;
  distributed::MessageReader reader(in[0], 0);
  if (in[0].size() < sizeof magic || reader.get<std::uint32_t>() != magic)
    throw distributed::RankError(0, "does not --resume: all must, or none");
  const auto count = static_cast<std::size_t>(reader.get<std::uint64_t>());
  const char* numbers = reader.take(count, sizeof(std::size_t));
  reader.finish();
  std::vector<std::size_t> first(count);
  if (count > 0) std::memcpy(first.data(), numbers, count * sizeof(std::size_t));
  const std::set<std::size_t> known(frames.begin(), frames.end());
  for (const std::size_t frame : first)
    if (known.count(frame) == 0)
      throw io::InputError(options.inputs[0] + ": has no frame " + std::to_string(frame) +
                           ", which rank 0 has: all ranks must have the same recording, and --frames");
  return first;
}

/** \brief Clouds of scanners, whose images nobody has: the spatial hash alone fuses them. */
int runPlain(const Options& options, const CLI::App& app) {
  if (options.method != "fuse_flow")
    throw io::OptionError("--method " + options.method + ": " + options.inputs[0] +
                          " is a cloud, without the images it was measured in, must be fuse_flow");
  for (const auto& [given, option] : {std::pair{!options.recording.views.empty(), "--views"},
                                      {options.recording.slide != 0, "--slide"},
                                      {options.recording.depth_scale.has_value(), "--depth-scale"},
                                      {!options.recording.intrinsics.empty(), "--intrinsics"},
                                      {options.refine_extrinsics, "--refine-extrinsics"}})
    if (given) throw io::OptionError(std::string(option) + ": " + options.inputs[0] + " is a cloud, must not be given");
  io::PlainClouds clouds(options.inputs, options.recording.poses);
  command_line::printWarnings("fuse_flow_fuse", clouds.warnings());
  warnOf(command_line::cameraMaskAdvice(options.camera_mask, clouds.scanners().size()));
  const std::vector<std::size_t> all = clouds.frames();
  std::vector<std::size_t> frames = options.frames.empty() ? all : io::parseRangeOf(options.frames, all, "--frames");
  if (options.normals && !clouds.haveNormals()) throw io::OptionError("--normals: " + options.inputs[0] + " has none");
  const auto files = std::make_shared<io::CloudFiles>(options.output, options.format, frames.size());
  io::InputFiles inputs(clouds.inputs());
  inputs.add(options.config);
  for (const std::size_t frame : frames) inputs.refuseToReplace("-o", files->pathOf(frame));
  if (!options.report.empty()) inputs.refuseToReplace("--report", options.report);
  if (options.resume) {
    const std::vector<std::size_t> missing = withoutCloud(options, *files, frames);
    for (const std::size_t frame : frames) files->leaveToAnother(frame);
    frames = missing;
    if (frames.empty()) return command_line::kSuccess;
  }
  command_line::printWarnings(
      "fuse_flow_fuse",
      {"clouds without their images: the spatial hash alone fuses them, on the CPU; nothing says how sure a "
       "point is, nor whether another scanner saw through it, and nothing is measured"});
  for (const std::string& option : withoutEffectOnClouds(app))
    command_line::printWarnings("fuse_flow_fuse", {option + " has no effect on clouds without their images"});
  io::QualityReport::Options report_options;
  report_options.measure = false;
  report_options.file = options.report;
  io::QualityReport report("spatial_hash", clouds.scanners(), report_options);
  pcl::PointCloud<io::PointFusedNormal> points;
  std::vector<std::uint32_t> scanners;
  io::catchInterrupts();
  std::size_t done = 0, points_in = 0, points_out = 0;
  for (const std::size_t number : frames) {
    if (io::interrupt_requested) break;
    const auto frame = std::make_shared<io::FusedFrame>();
    frame->number = number;
    clouds.read(number, points, scanners);
    const auto start = std::chrono::steady_clock::now();
    try {
      io::fusePlainCloud(points, scanners, options.method_options.parameters.aggregation,
                         options.method_options.threads, frame->with_normals);
    } catch (const pcl::PCLException& error) {
      throw io::InputError(options.inputs[0] + ": frame " + std::to_string(number) + ": " + whyNotFused(error));
    }
    frame->statistics.total_ms = frame->statistics.fuse_ms = 1e3 * seconds(start);
    frame->statistics.measured_points = points.size();
    frame->statistics.fused_points = frame->with_normals.size();
    frame->has_normals = options.normals;
    frame->has_camera_mask = options.camera_mask;
    io::withoutNormals(frame->with_normals, frame->cloud);
    points_in += points.size();
    points_out += frame->with_normals.size();
    files->take(frame);
    report.take(frame);
    ++done;
  }
  std::vector<std::string> noticed = files->finish();
  if (const std::string odd = oddCloud(points_in, points_out); !odd.empty()) noticed.push_back(odd);
  report.finish();
  std::cout << report.report().summary();
  for (const std::string& line : noticed) std::cout << "  " << line << "\n";
  return command_line::endOfFrames("fuse_flow_fuse", done, frames.size());
}

/** \brief Of several ranks: what each reads, and what none can do. */
void prepareRanks(Options& options, const std::string& spec) {
  if (options.ranks == nullptr) return;
  std::vector<std::string> said;
  if (!options.report.empty())
    throw io::OptionError("--report: several ranks write none; leave it out, or run one process");
  if (options.evaluate)
    said.push_back(options.share_frames ? "each rank has some of the frames alone: nothing is measured"
                                        : "no rank has the images of all cameras: nothing is measured");
  options.evaluate = false;
  if (!options.share_frames) {
    if (options.method != "fuse_flow")
      throw io::OptionError("--method " + options.method + ": runs in one process only");
    if (options.method_options.device == "gpu")
      throw io::OptionError(
          "--device gpu: ranks that share the cameras of a frame fuse on their CPUs; --ranks frames uses GPUs");
    if (spec == "stereo")
      throw io::OptionError(
          "--depth-source stereo: needs the images of all cameras, must be --ranks frames, or one process");
    options.recording.part = options.ranks->rank();
    options.recording.parts = options.ranks->size();
  } else if (options.refine_extrinsics) {
    said.push_back("--refine-extrinsics follows cameras through the frames of one rank alone");
  }
  if (options.ranks->isFirst()) command_line::printWarnings("fuse_flow_fuse", said);
}

/** \brief Those of this rank, in turn, where frames are shared. */
std::vector<std::size_t> ownFrames(const Options& options, const std::vector<std::size_t>& all) {
  if (options.ranks == nullptr || !options.share_frames) return all;
  std::vector<std::size_t> own;
  for (auto k = static_cast<std::size_t>(options.ranks->rank()); k < all.size();
       k += static_cast<std::size_t>(options.ranks->size()))
    own.push_back(all[k]);
  return own;
}

io::PoseMakers poseMakers(const Options& options) {
  constexpr std::uint64_t interval = 30'000;  // microseconds, as in one process: ranks give the same clouds
  if (!options.sharesCameras()) return {};
  return io::makersOfSharedPoses(options.ranks->communicator(), options.method_options.threads, interval);
}

int run(Options& options, const command_line::MethodArguments& arguments) {
  prepareRanks(options, arguments.depthSource());
  io::DistributedMethod* distributed = nullptr;
  const auto make = [&]() -> std::unique_ptr<io::Method> {
    if (!options.sharesCameras()) return io::makeMethod(options.method, options.method_options);
    auto shared = io::makeDistributedFusion(options.ranks->communicator(), options.method_options, options.share);
    distributed = shared.get();
    return shared;
  };
  std::unique_ptr<io::Method> method = make();
  const std::unique_ptr<io::Recording> recording =
      command_line::openRecording("fuse_flow_fuse", options.inputs, options.recording, options.stereo);
  const io::StereoRecording* stereo = io::stereoOf(recording.get());
  if (stereo) {  // what made the depth is known now
    options.method_options = methodOptions(options, arguments);
    if (options.sharesCameras())
      throw io::OptionError(
          "a recording without depth: its depth is estimated from all cameras, must be --ranks frames, or one process");
    method = make();
  }
  command_line::printWarnings("fuse_flow_fuse",
                              io::estimatedDepthAdvice(stereo ? "stereo" : recording->kind(), options.method,
                                                       options.method_options.parameters));
  warnOf(command_line::cameraMaskAdvice(options.camera_mask, recording->cameras().size()));
  const std::vector<std::size_t> all_frames = io::chooseFrames(*recording, options.frames);
  std::vector<std::size_t> frames = ownFrames(options, all_frames);

  const auto files = std::make_shared<io::CloudFiles>(options.output, options.format, all_frames.size());
  checkOutputs(options, *recording, *files, frames);
  const std::size_t of_frames = frames.size();
  if (options.resume) {
    const std::vector<std::size_t> all_own = frames;
    frames = options.writes() ? withoutCloud(options, *files, all_own) : all_own;
    if (options.sharesCameras()) frames = asTheFirstRank(options, frames, all_own);
    if (frames.empty()) return command_line::kSuccess;
  }
  const std::set<std::size_t> own_frames(frames.begin(), frames.end());
  for (const std::size_t frame : all_frames)
    if (own_frames.count(frame) == 0) files->leaveToAnother(frame);

  std::vector<std::string> cameras;
  for (const Camera& camera : recording->cameras()) cameras.push_back(camera.name);
  const auto report = std::make_shared<io::QualityReport>(options.method, std::move(cameras), reportOptions(options));
  Sinks sinks(options.writes() ? std::vector<std::shared_ptr<io::FrameSink>>{files, report}
                               : std::vector<std::shared_ptr<io::FrameSink>>{},
              options.overlap);
  Frames reading(*recording, frames, options.overlap,
                 host::resolveThreads(static_cast<int>(options.method_options.threads)));

  io::FramePool pool;
  io::LiveExtrinsics extrinsics(options.method_options.device, options.method_options.warn, poseMakers(options));
  io::catchInterrupts();
  Progress progress(frames.size());
  const auto start = std::chrono::steady_clock::now();
  std::size_t done = 0;
  const io::StillThere still_there(*recording);
  std::map<std::size_t, std::string> ended;  // by camera
  std::vector<bool> estimated(recording->cameras().size(), arguments.depthSource() == "stereo");
  for (std::size_t k = 0; stereo && k < estimated.size(); ++k) estimated[k] = estimated[k] || stereo->estimates(k);
  io::InputChecks checks(options.method, options.method_options.parameters, std::move(estimated));
  io::EmptyClouds empty(options.method, options.method_options);
  for (const std::size_t number : frames) {
    if (io::interrupt_requested) break;
    const std::shared_ptr<io::FusedFrame> frame = pool.next();
    frame->number = number;
    try {
      reading.next(number, frame->input);
      still_there.check(frame->input);
      for (std::size_t i = 0; options.sharesCameras() && i < frame->input.rig.views.size();
           ++i)  // files that are read whole
        if (!io::isInPart(i, frame->input.rig.views.size(), options.recording.part, options.recording.parts))
          frame->input.rig.views[i] = {};
      for (const io::DamagedView& view : frame->input.ended) ended[view.view] = view.message;
      if (options.refine_extrinsics) extrinsics.place(frame->input.rig);
      checks.look(frame->input);
      if (!options.writes())
        for (const io::DamagedView& view : frame->input.damaged)
          std::cerr << "fuse_flow_fuse, rank " << options.ranks->rank() << ": " << view.message << std::endl;
      for (const CameraMotion& motion : options.writes() ? extrinsics.moved() : std::vector<CameraMotion>())
        std::cerr << io::describe(motion, frame->input.rig.cameras) << std::endl;
      method->fuse(frame->input.rig, frame->cloud);
    } catch (const io::InputError&) {
      sinks.drain();
      throw;
    } catch (const distributed::RankError&) {
      sinks.drain();
      throw;
    } catch (const pcl::PCLException& error) {
      sinks.drain();
      throw io::InputError(options.inputs[0] + ": frame " + std::to_string(number) + ": " + whyNotFused(error));
    } catch (const std::bad_alloc&) {
      sinks.drain();
      throw io::InputError(options.inputs[0] + ": frame " + std::to_string(number) + ": not enough memory for its " +
                           std::to_string(recording->cameras().size()) + " cameras; --views leaves some out");
    }
    frame->has_normals = options.normals;
    frame->has_camera_mask = options.camera_mask;
    if (options.method_options.morePerPoint()) frame->with_normals = method->withNormals();
    frame->statistics = method->statistics();
    checks.lookAt(frame->input.rig, frame->statistics);
    if (options.writes()) empty.look(number, frame->input.rig, frame->cloud.size(), !options.sharesCameras());
    sinks.take(frame);
    progress.show(++done);
  }
  progress.endLine();
  reading.end();  // where it was interrupted, the next frames were on their way
  report->note("side_by_side", options.overlap);
  if (options.resume) report->note("clouds_of_before", of_frames - frames.size());
  if (const nlohmann::json alone = imagesWithoutPartner(*recording); !alone.empty())
    report->note("images_without_partner", alone);
  if (stereo) {
    nlohmann::json depth = stereo->json();
    depth["depth_source"] = arguments.depthSource();
    report->note("estimated_depth", std::move(depth));
  }
  const std::vector<std::string> noticed = sinks.finish();
  const std::string shared = distributed ? distributed->summary() : "";
  if (!options.writes() || frames.empty()) {  // what a rank saw of its own cameras nobody else has seen
    for (const std::string& complaint : checks.complaints())
      std::cout << "  rank " << options.ranks->rank() << ": " << complaint << "\n";
    return command_line::endOfFrames("fuse_flow_fuse", done, frames.size());
  }
  if (options.ranks && options.share_frames) std::cout << "rank " << options.ranks->rank() << ": ";
  std::cout << report->report().summary();
  if (!shared.empty()) std::cout << "  " << shared << "\n";
  if (stereo) std::cout << "  " << stereo->summary() << "\n";
  for (const auto& [camera, message] : ended) std::cout << "  " << message << "\n";
  for (const std::string& complaint : checks.complaints()) std::cout << "  " << complaint << "\n";
  for (const std::string& complaint : empty.complaints()) std::cout << "  " << complaint << "\n";
  for (const std::string& line : noticed) std::cout << "  " << line << "\n";
  if (options.overlap && done > 1) std::cout << sideBySide(done, seconds(start)) << "\n";
  return command_line::endOfFrames("fuse_flow_fuse", done, frames.size());
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Fuses a recording of several depth cameras into one clean cloud a frame.", "fuse_flow_fuse");
  command_line::RecordingArguments recording(app);
  recording.input()->required();
  app.add_option("-o,--output", options.output, "a .ply or .pcd file for one frame, else a folder")
      ->check(command_line::path())
      ->required();
  app.add_option("--report", options.report, "write figures per frame and in total to this JSON file")
      ->check(command_line::path());
  app.add_option("--frames", options.frames, "A:B:STEP, B not included")
      ->multi_option_policy(CLI::MultiOptionPolicy::Join);
  app.add_flag("--refine-extrinsics", options.refine_extrinsics,
               "estimate the poses from what the cameras see, and follow them from frame to frame")
      ->excludes(app.get_option("--slide"));
  app.add_option("--format", options.format, "of the files in the output folder")
      ->check(CLI::IsMember({"ply", "pcd"}))
      ->capture_default_str();
  app.add_flag(
         "--resume", options.resume,
         "leave out the frames whose clouds are there already: after a run that ended early, with the same options")
      ->excludes(app.get_option("--refine-extrinsics"));
  app.add_flag(
      "!--no-overlap", options.overlap,
      "read, fuse, write and measure one after the other, and not side by side: for measuring how long each takes");
  app.add_flag("--normals", options.normals, "write the surface's normal with each point, facing its cameras");
  command_line::addCameraMaskOption(app, options.camera_mask);
  app.add_flag("!--no-quality", options.evaluate,
               "do not measure noise, double surfaces, violations, coverage, flicker and E_MC");
  command_line::addQualityOptions(app, options.quality);
  command_line::MethodArguments method(app);
  command_line::StereoArguments stereo(app);
  const command_line::RanksArgument shared(app);
  const command_line::RankShareArguments rank_share(app);
  return command_line::runTool(app, argc, argv, [&] {
    const std::unique_ptr<command_line::Ranks> ranks = command_line::Ranks::ofThisRun();
    options.ranks = ranks.get();
    options.share_frames = shared.shareFrames();
    if (ranks) options.share = rank_share.of(ranks->rank());
    options.frames = command_line::joinedList(options.frames);
    options.inputs = recording.inputs();
    options.recording = recording.options();
    options.method = method.method();
    options.method_options = methodOptions(options, method);
    if (!ranks || ranks->isFirst())
      for (const std::vector<std::string>& lines : {method.advice(), rank_share.advice(options.sharesCameras())})
        command_line::printWarnings("fuse_flow_fuse", lines);
    options.stereo = stereo.options("fuse_flow_fuse");
    options.stereo.threads = options.method_options.threads;
    options.stereo.device = options.method_options.device;
    options.stereo.all_estimated = [&](std::size_t views) { return method.assumeStereo(views); };
    options.recording.threads = static_cast<int>(options.method_options.threads);
    options.overlap = options.overlap && options.method_options.threads != 1;
    options.config = command_line::configFileOf(app);
    command_line::requireThreads(options.method_options.threads);
    const auto fuse = [&] {
      if (!io::PlainClouds::are(options.inputs)) return run(options, method);
      if (ranks)
        throw io::OptionError("clouds without their images: one process fuses them, must not be started by mpirun");
      return runPlain(options, app);
    };
    return ranks ? ranks->guard("fuse_flow_fuse", fuse) : fuse();
  });
}
