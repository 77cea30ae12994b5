#pragma once

#include "command_line/ranks.h"
#include "live/live_ranks.h"
#include "live/live_rig.h"
#include "live/played_cameras.h"

#include <fuse_flow/recordings/input_files.h>

#include <CLI/CLI.hpp>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace fuse_flow::command_line {

/** \brief Cameras that run, on the command line: devices, or a recording that is played as if it were cameras. */
class LiveArguments {
 public:
  /** \param loops a recording is played again and again if nobody asks for once */
  explicit LiveArguments(CLI::App& app, bool loops = false);
  LiveArguments(const LiveArguments&) = delete;
  LiveArguments& operator=(const LiveArguments&) = delete;

  /** \brief Opens devices, or a recording. \param without_poses cameras may stand nobody knows where \throws InputError, OptionError */
  std::unique_ptr<io::LiveRig> open(const std::string& tool, const std::vector<std::string>& inputs,
                                    const io::RecordingOptions& recording, bool without_poses) const;
  /** \brief At rank 0 of several: opens what is here, and has the cameras of all ranks. \param inputs may be none, of a rank without cameras;
   *  the recording's cameras are shared out: each rank plays as many, and those that follow one another */
  std::unique_ptr<io::LiveRig> open(const std::string& tool, const std::vector<std::string>& inputs,
                                    const io::RecordingOptions& recording, io::LeadingRank& leader, Ranks& ranks) const;
  /** \brief At any other rank: opens what is here, and joins rank 0. */
  std::unique_ptr<io::FollowingRank> join(const std::string& tool, const std::vector<std::string>& inputs,
                                          const io::RecordingOptions& recording, Ranks& ranks) const;
  /** \brief Whether any of the inputs is a device. */
  static bool anyDevice(const std::vector<std::string>& inputs);
  /** \brief Options of these that were given: they ask for cameras that run. */
  std::vector<std::string> given() const;
  /** \brief Whether a recording is played again and again. */
  bool loops() const { return play_.loop; }
  /** \brief Of a recording that is played; 1: as it was taken. */
  double speed() const { return play_.speed; }
  /** \brief Seconds after which it ends; absent: when somebody ends it. */
  std::optional<double> seconds() const { return seconds_; }

 private:
  using Sources = std::vector<std::unique_ptr<io::CameraSource>>;

  /** \brief What is played, and how: of ranks that share it out, the same of each. */
  std::string played(const std::vector<std::string>& inputs) const;
  Sources openSources(const std::string& tool, const std::vector<std::string>& inputs,
                      const io::RecordingOptions& recording, Ranks* ranks) const;
  std::unique_ptr<io::CameraSource> openPlayed(const std::string& tool, const std::vector<std::string>& inputs,
                                               const io::RecordingOptions& recording, const io::RankPart& part) const;
  std::unique_ptr<io::LiveRig> rigOf(const std::string& tool, Sources sources, const io::RecordingOptions& recording,
                                     bool devices, bool without_poses) const;

  std::vector<CLI::Option*> options_, of_play_;
  io::PlayOptions play_;
  std::vector<std::string> stalls_;
  std::string frames_;
  double tolerance_ms_{8}, max_wait_ms_{100}, jitter_ms_{0};
  std::optional<double> seconds_;
};

/** \brief Makes the folder that a recording goes to. Throws OptionError, naming the option, if it is no .mcap file, or would replace an input. */
void prepareRecording(const std::string& option, const std::string& path, io::InputFiles inputs);

/** \brief What happens while cameras run: lines on the standard error stream as things happen, and how the cameras do, every few seconds. */
class LiveLog {
 public:
  /** \param every seconds between two reports; 0: none */
  LiveLog(std::string tool, double every) : tool_(std::move(tool)), every_(every) {}
  /** \brief Call it some times a second. \param more asked for what is added to the first line of a report, when there is one */
  void look(io::LiveRig& rig, const std::function<std::string()>& more);
  /** \brief At the end: what of each camera came, was lost, and was fused. */
  static std::string summary(const io::LiveRig& rig);

 private:
  std::string tool_;
  double every_;
  std::chrono::steady_clock::time_point start_{std::chrono::steady_clock::now()}, last_{start_};
};

}  // namespace fuse_flow::command_line
