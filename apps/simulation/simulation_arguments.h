#pragma once

#include "io/option_checks.h"
#include "simulation/rig_layout.h"
#include "simulation/simulator.h"

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace fuse_flow::simulation {

/** \brief "a, b, c". */
inline std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

/** \brief The simulated rig on the command line; scene, rate and threads are the tools' own. */
class SimulationArguments {
 public:
  explicit SimulationArguments(CLI::App& app) {
    const std::string rigs = "ring-N or walls-N, N from 1 to 64, or with -narrow behind it";
    add(app.add_option("--rig", options_.rig, rigs)->check(io::detail::makeCheck(rigs, isRigName)));
    add(app.add_option("--sensor", options_.sensor, listed(sensorNames()))->check(io::oneOf(sensorNames())));
    add(app.add_option("--seed", options_.seed, "the same seed gives the same bytes"));
    add(app.add_option("--scale", options_.scale, "of the images' sides, (0, 2]")->check(io::positiveNumberUpTo(2)));
    given_.push_back(app.add_flag("--no-color", no_color_, "depth only"));
    given_.push_back(
        app.add_option("--position-error", position_error_mm_, "calibrated positions are off by this, mm"));
    given_.push_back(
        app.add_option("--rotation-error", rotation_error_deg_, "calibrated orientations are off by this, degrees"));
    given_.push_back(
        app.add_option("--depth-bias", depth_bias_mm_, "each camera's depth is off by a constant in +- this, mm"));
    given_.push_back(app.add_option("--knock", knock_mm_,
                                    "from --knock-frame on the last camera stands this far from where it stood, mm"));
    given_.push_back(app.add_option("--knock-rotation", knock_deg_, "and is turned by this, degrees"));
    given_.push_back(app.add_option("--knock-frame", options_.faults.knock_frame, "when"));
    given_.push_back(
        app.add_option("--drop-rate", options_.faults.drop_rate, "share of frames that a camera loses, [0, 1]"));
    given_.push_back(app.add_option("--marker", options_.marker,
                                    "side of an AprilTag that someone shows to the cameras, m; 0: nobody does"));
    given_.push_back(
        app.add_option("--out-of-sync", out_of_sync_ms_, "each camera's time is off by a constant in +- this, ms"));
  }
  SimulationArguments(const SimulationArguments&) = delete;
  SimulationArguments& operator=(const SimulationArguments&) = delete;

  /** \brief None of them means anything without that option. */
  void need(CLI::Option* option) {
    for (CLI::Option* mine : given_) mine->needs(option);
  }

  SimulationOptions options() const {
    SimulationOptions result = options_;
    result.color = !no_color_;
    result.faults.position_error = 0.001 * position_error_mm_;
    result.faults.rotation_error = rotation_error_deg_ * 3.14159265358979323846 / 180;
    result.faults.depth_bias = 0.001 * depth_bias_mm_;
    result.faults.knock = 0.001 * knock_mm_;
    result.faults.knock_rotation = knock_deg_ * 3.14159265358979323846 / 180;
    result.faults.out_of_sync = 0.001 * out_of_sync_ms_;
    return result;
  }

 private:
  void add(CLI::Option* option) { given_.push_back(option->capture_default_str()); }

  SimulationOptions options_;
  double position_error_mm_{0};
  double rotation_error_deg_{0};
  double depth_bias_mm_{0};
  double knock_mm_{0};
  double knock_deg_{0};
  double out_of_sync_ms_{0};
  bool no_color_{false};
  std::vector<CLI::Option*> given_;
};

}  // namespace fuse_flow::simulation
