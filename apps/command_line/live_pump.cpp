#include "command_line/live_pump.h"

#include "calibration/shared_poses.h"
#include "command_line/arguments/recording_arguments.h"
#include "command_line/message_of.h"
#include "recordings/files/file_io.h"
#include "recordings/files/interrupt.h"
#ifdef FUSE_FLOW_WITH_STREAM
#include "sinks/stream_sink.h"
#endif

#include <algorithm>
#include <cstdio>
#include <iostream>

namespace fuse_flow::command_line {
namespace {

std::vector<bool> estimatedBy(const io::ViewStereo* stereo, const io::LiveRig& rig) {
  std::vector<bool> estimated;
  for (std::size_t k = 0; k < rig.cameras().size(); ++k) estimated.push_back(stereo && stereo->estimates(k));
  return estimated;
}

/** \brief Of ranks: frames wait while they search for poses together, so not in each. */
io::PoseMakers sharedPoses(distributed::Communicator& communicator, const io::MethodOptions& options) {
  constexpr std::uint64_t interval = 250'000;  // microseconds
  return io::makersOfSharedPoses(communicator, options.threads, interval);
}

double secondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

void Times::add(double ms) {
  const auto bin = static_cast<std::size_t>(std::clamp(ms / kBin, 0.0, static_cast<double>(bins_.size() - 1)));
  ++bins_[bin];
  ++count_;
}

double Times::quantile(double share) const {
  std::uint64_t below = 0;
  for (std::size_t bin = 0; bin < bins_.size(); ++bin)
    if (static_cast<double>(below += bins_[bin]) >= share * static_cast<double>(count_) && count_ > 0)
      return kBin * (static_cast<double>(bin) + 0.5);
  return 0;
}

bool LiveChecks::look(const io::LiveInstant& instant, io::LoadedFrame& frame) {
  if (secondsSince(last_look_) < 1) return false;
  for (std::size_t k = 0; k < instant.held.size(); ++k)
    if (instant.held[k]) frame.images[k].assumed_confidence_step = instant.held[k]->assumed_confidence_step;
  InputChecks::look(frame);
  last_look_ = std::chrono::steady_clock::now();
  return true;
}

LivePump::LivePump(Options options, io::LiveRig& rig, std::vector<std::shared_ptr<io::BackgroundSink>> sinks)
    : options_(std::move(options)),
      rig_(rig),
      sinks_(std::move(sinks)),
      extrinsics_(
          options_.method_options.device, options_.method_options.warn,
          options_.leader ? sharedPoses(options_.leader->communicator(), options_.method_options) : io::PoseMakers()),
      checks_(options_.method, options_.method_options.parameters, estimatedBy(options_.stereo, rig),
              options_.leader == nullptr),
      empty_(options_.method, options_.method_options),
      log_(options_.tool, options_.status) {
  if (options_.leader) {
    auto method = io::makeDistributedFusion(options_.leader->communicator(), options_.method_options, options_.share);
    distributed_ = method.get();
    method_ = std::move(method);
  } else if (!sinks_.empty() || !options_.instant) {
    method_ = io::makeMethod(options_.method, options_.method_options);
  }
}

void LivePump::run(const std::atomic<bool>& stop) {
  const std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
  // Depth takes longest by far: the next frame's is estimated while this one is fused.
  if (options_.stereo)
    prepared_ =
        std::make_unique<io::PreparedInstants>(rig_, [this](io::LiveInstant& instant) { estimateDepth(instant); });
  const auto running = [&] { return prepared_ ? prepared_->running() : rig_.running(); };
  while (!stop && !io::interrupt_requested && running() && secondsSince(start) < options_.seconds.value_or(1e12))
    step();
  prepared_ = nullptr;
  seconds_ = secondsSince(start);
  if (!options_.leader) return;
  options_.leader->stop();
  shared_ = distributed_->summary();
}

std::string LivePump::summary() const {
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
  if (!shared_.empty()) text += "  " + shared_ + "\n";
  if (options_.stereo) text += "  " + options_.stereo->summary() + "\n";
  return text + LiveLog::summary(rig_);
}

std::shared_ptr<io::LiveInstant> LivePump::next() {
  constexpr std::chrono::milliseconds most(100);
  if (prepared_) return prepared_->next(most);
  const auto instant = std::make_shared<io::LiveInstant>();
  if (!options_.leader) return rig_.next(most, *instant) ? instant : nullptr;
  const std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
  do {
    options_.leader->poll();
    if (rig_.next(std::chrono::milliseconds(2), *instant)) return instant;
  } while (std::chrono::steady_clock::now() - start < most);
  return nullptr;
}

void LivePump::step() {
  const std::shared_ptr<io::LiveInstant> instant = next();
  if (options_.recorder) options_.recorder->check();
  if (instant) {
    if (options_.instant) options_.instant(instant);
    if (method_) fuse(*instant);
  }
  if (options_.tick) options_.tick();
  if (options_.leader) options_.leader->poll();  // or cameras of other ranks would seem silent while a frame was fused
  log_.look(rig_, [&] {
    if (!method_ && !options_.recorder) return std::string();
    std::string more = std::to_string(fusing_.count()) + " frames fused";
    if (options_.recorder)
      more += ", " + std::to_string(options_.recorder->written()) + " views written, " +
              std::to_string(options_.recorder->lost()) + " lost for want of time";
    if (options_.more) more += options_.more();
    return more;
  });
}

void LivePump::estimateDepth(io::LiveInstant& instant) {
  const std::shared_ptr<io::LoadedFrame> frame = estimated_.next();
  frame->rig = instant.rig;
  frame->images.resize(instant.held.size());
  options_.stereo->complete("frame " + std::to_string(instants_++), *frame);
  instant.rig = frame->rig;
  instant.estimated = frame;
}

void LivePump::fuse(const io::LiveInstant& instant) {
  const std::shared_ptr<io::FusedFrame> frame = pool_.next();
  frame->number = fusing_.count();
  frame->arrived = instant.arrived;
  frame->input.rig = instant.rig;
  frame->live = instant.held;
  if (instant.estimated) frame->live.emplace_back(instant.estimated, &instant.estimated->images[0]);  // it stays
  frame->input.images.assign(instant.held.size(), {});
  if (options_.leader) options_.leader->fuse(instant, options_.refine_extrinsics);  // what follows all ranks do
  if (options_.refine_extrinsics) extrinsics_.place(frame->input.rig);
  for (const CameraMotion& motion : extrinsics_.moved())
    std::cerr << io::describe(motion, frame->input.rig.cameras) << std::endl;
  const bool look = checks_.look(instant, frame->input);
  const std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
  try {
    frame->encoded = nullptr;
#ifdef FUSE_FLOW_WITH_STREAM
    if (options_.method_options.encoding) frame->encoded = method_->fuseEncoded(frame->input.rig, io::timesOf(*frame));
#endif
    if (!frame->encoded) method_->fuse(frame->input.rig, frame->cloud);
  } catch (const distributed::RankError&) {
    throw;
  } catch (const pcl::PCLException& error) {
    throw io::InputError("frame " + std::to_string(frame->number) + ": " + io::messageOf(error));
  }
  fusing_.add(1e3 * secondsSince(start));
  latency_.add(1e-3 * static_cast<double>((rig_.now() - instant.arrived).count()));
  frame->has_normals = options_.method_options.normals;
  frame->has_camera_mask = options_.method_options.camera_mask;
  if (options_.method_options.morePerPoint() && !frame->encoded) frame->with_normals = method_->withNormals();
  frame->statistics = method_->statistics();
  if (look) checks_.lookAt(frame->input.rig, frame->statistics);
  std::size_t points = frame->cloud.size();
#ifdef FUSE_FLOW_WITH_STREAM
  if (frame->encoded) points = frame->encoded->points;
#endif
  empty_.look(frame->number, frame->input.rig, points, !options_.leader);
  for (const std::shared_ptr<io::BackgroundSink>& sink : sinks_) sink->take(frame);
}

io::StereoOptions stereoOfLive(const std::string& tool, const StereoArguments& stereo, bool ranks,
                               MethodArguments& method, io::MethodOptions& options) {
  io::StereoOptions result = stereo.options(tool);
  result.estimate = result.estimate && !ranks;
  result.threads = options.threads;
  result.device = options.device;
  result.all_estimated = [&](std::size_t views) {
    std::string line = method.assumeStereo(views);
    options.parameters = method.options().parameters;
    return line;
  };
  return result;
}

std::unique_ptr<io::ViewStereo> stereoOf(const std::string& tool, const io::LiveRig& rig,
                                         const io::StereoOptions& options) {
  const std::vector<bool>& lacks_depth = rig.lacksDepth();
  if (std::count(lacks_depth.begin(), lacks_depth.end(), true) == 0) return nullptr;
  if (!options.estimate) {
    warnOfMissingDepth(tool, lacks_depth);
    return nullptr;
  }
  auto stereo =
      std::make_unique<io::ViewStereo>(rig.cameras(), lacks_depth, rig.colored(), "cameras that run", options);
  printWarnings(tool, stereo->warnings());
  return stereo;
}

void requireOfLiveRanks(const std::string& method, const io::MethodOptions& options) {
  if (method != "fuse_flow") throw io::OptionError("--method " + method + ": runs in one process only");
  if (options.device == "gpu")
    throw io::OptionError("--device gpu: ranks that share the cameras of a frame fuse on their CPUs");
}

void followLiveRank(const std::string& tool, Ranks& ranks, const LiveArguments& live,
                    const std::vector<std::string>& inputs, const io::RecordingOptions& recording,
                    const io::MethodOptions& options, const io::RankShare& share, bool refine_extrinsics) {
  const std::string name = "rank " + std::to_string(ranks.rank());
  const std::unique_ptr<io::FollowingRank> rank = live.join(tool + ", " + name, inputs, recording, ranks);
  const auto method = io::makeDistributedFusion(ranks.communicator(), options, share);
  LiveChecks checks("fuse_flow", options.parameters, std::vector<bool>(rank->cameras().size(), false), false);
  io::LiveExtrinsics extrinsics(options.device, {}, sharedPoses(ranks.communicator(), options));
  io::LoadedFrame frame;
  io::Method::Cloud nothing;  // rank 0 gets the clouds
  rank->run([&](const io::LiveInstant& instant, bool refines) {
    frame.rig = instant.rig;
    frame.images.assign(instant.held.size(), {});
    if (std::exchange(refine_extrinsics, false) && !refines)
      printWarnings(tool + ", " + name, {"--refine-extrinsics has no effect here: rank 0 must be given it"});
    if (refines) extrinsics.place(frame.rig);
    checks.look(instant, frame);
    method->fuse(frame.rig, nothing);
  });
  method->summary();
  for (const std::string& line : checks.complaints()) std::cout << "  " << name << ": " << line << "\n";
  std::cout << std::flush;
}

}  // namespace fuse_flow::command_line
