#pragma once

#include "calibration/live_extrinsics.h"
#include "command_line/arguments/live_arguments.h"
#include "command_line/arguments/method_arguments.h"
#include "command_line/arguments/stereo_arguments.h"
#include "input_checks/empty_clouds.h"
#include "input_checks/input_checks.h"
#include "live/live_ranks.h"
#include "live/live_rig.h"
#include "live/prepared_instants.h"
#include "live/rig_recorder.h"
#include "methods/distributed_fusion.h"
#include "methods/method.h"
#include "recordings/pool.h"
#include "sinks/background_sink.h"
#include "stereo/view_stereo.h"

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace fuse_flow::command_line {

/** \brief How long frames took, in milliseconds, in a histogram: an hour of them needs no more memory than a second. */
class Times {
 public:
  void add(double ms);
  /** \param share 0.5: the median; 0 if there is none */
  double quantile(double share) const;
  std::uint64_t count() const { return count_; }

 private:
  static constexpr double kBin = 0.1;  // ms
  std::vector<std::uint64_t> bins_ = std::vector<std::uint64_t>(100000);
  std::uint64_t count_{0};
};

/** \brief Looks at the input of cameras that run once a second, since it takes time of its own. */
class LiveChecks : public io::InputChecks {
 public:
  using InputChecks::InputChecks;

  /** \brief Whether it has looked. \param frame with the rig of the instant, and an image a camera, empty */
  bool look(const io::LiveInstant& instant, io::LoadedFrame& frame);

 private:
  std::chrono::steady_clock::time_point last_look_;
};

/** \brief Takes instants from a rig, fuses them where somebody wants clouds, and hands everything on. */
class LivePump {
 public:
  struct Options {
    std::string tool;  ///< its name, for the log
    std::string method;
    /** \brief With `encoding`, frames come encoded where the method can do that on a GPU, and then without clouds. */
    io::MethodOptions method_options;
    bool refine_extrinsics{false};
    double status{5};               ///< seconds between two lines of the log; 0: none
    std::optional<double> seconds;  ///< after which it ends
    /** \brief Hears of each instant, with the depth of all views, before it is fused. */
    std::function<void(const std::shared_ptr<io::LiveInstant>&)> instant;
    /** \brief What a line of the log says, beside the frames that were fused. */
    std::function<std::string()> more;
    /** \brief Called some times a second. */
    std::function<void()> tick;
    io::RigRecorder* recorder{nullptr};
    /** \brief Of cameras that measure no depth; null: they stay missing. See stereoOf(). */
    io::ViewStereo* stereo{nullptr};
    /** \brief Where ranks share the cameras, rank 0; \p method fuses then over all of them. The LiveRig was opened with it. */
    io::LeadingRank* leader{nullptr};
    /** \brief With \p leader: of this rank. */
    io::RankShare share;
  };

  /** \param rig not started yet  \param sinks for the clouds; without any, and with Options::instant, nothing is fused */
  LivePump(Options options, io::LiveRig& rig, std::vector<std::shared_ptr<io::BackgroundSink>> sinks);

  /** \brief Until the cameras end, the time is over, somebody interrupts the program, or stop is true. \throws what ends the run */
  void run(const std::atomic<bool>& stop);

  /** \brief What was fused, and how long it took; of each camera, what came. */
  std::string summary() const;
  /** \brief What was noticed of the input, one line each. */
  std::vector<std::string> complaints() const {
    std::vector<std::string> lines = checks_.complaints();
    for (std::string& line : empty_.complaints()) lines.push_back(std::move(line));
    return lines;
  }
  std::uint64_t fused() const { return fusing_.count(); }

 private:
  void step();
  /** \brief The latest instant, of all ranks where there are several, with depth of all views; null: none came in a while. */
  std::shared_ptr<io::LiveInstant> next();
  /** \brief Gives the views without depth theirs; on the thread of prepared_. */
  void estimateDepth(io::LiveInstant& instant);
  void fuse(const io::LiveInstant& instant);

  Options options_;
  io::LiveRig& rig_;
  std::vector<std::shared_ptr<io::BackgroundSink>> sinks_;
  std::unique_ptr<io::Method> method_;
  io::DistributedMethod* distributed_{nullptr};  ///< where method_ is one
  io::LiveExtrinsics extrinsics_;
  LiveChecks checks_;
  io::EmptyClouds empty_;
  io::FramePool pool_;
  io::Pool<io::LoadedFrame> estimated_;
  LiveLog log_;
  Times fusing_, latency_;
  std::uint64_t instants_{0};
  double seconds_{0};
  std::string shared_;                              ///< what ranks did, where there are several
  std::unique_ptr<io::PreparedInstants> prepared_;  ///< while it runs, where depth is estimated
};

/** \brief What estimates the depth of the cameras of a rig that measure none, with lines on the standard error stream that say so; null where every
 *  camera measures it. Throws InputError, OptionError. \param options not to be estimated: null, and a line that they are missing */
std::unique_ptr<io::ViewStereo> stereoOf(const std::string& tool, const io::LiveRig& rig,
                                         const io::StereoOptions& options);

/** \brief How such a tool estimates depth: not where \p ranks share the cameras, whose images stay where they are.
 *  \param options of the method; where no camera measures depth, what fits estimated depth goes there */
io::StereoOptions stereoOfLive(const std::string& tool, const StereoArguments& stereo, bool ranks,
                               MethodArguments& method, io::MethodOptions& options);

/** \brief Throws OptionError for what ranks that share the cameras of a live rig cannot do. */
void requireOfLiveRanks(const std::string& method, const io::MethodOptions& options);

/** \brief At a rank that is not the first: opens its cameras, joins, and fuses its part until rank 0 ends.
 *  \param refine_extrinsics whether this rank was given it: rank 0 decides, which is said */
void followLiveRank(const std::string& tool, Ranks& ranks, const LiveArguments& live,
                    const std::vector<std::string>& inputs, const io::RecordingOptions& recording,
                    const io::MethodOptions& options, const io::RankShare& share, bool refine_extrinsics);

}  // namespace fuse_flow::command_line
