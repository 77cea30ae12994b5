#pragma once

#include "simulation/simulator.h"

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace fuse_flow::command_line {

/** \brief "a, b, c". */
std::string listed(const std::vector<std::string>& names);

/** \brief The simulated rig on the command line; scene, rate and threads are the tools' own. */
class SimulationArguments {
 public:
  explicit SimulationArguments(CLI::App& app);
  SimulationArguments(const SimulationArguments&) = delete;
  SimulationArguments& operator=(const SimulationArguments&) = delete;

  /** \brief None of them means anything without that option. */
  void need(CLI::Option* option);

  simulation::SimulationOptions options() const;

 private:
  void add(CLI::Option* option);

  simulation::SimulationOptions options_;
  double position_error_mm_{0};
  double rotation_error_deg_{0};
  double depth_bias_mm_{0};
  double depth_distortion_mm_{0};
  double bump_mm_{0};
  double bump_deg_{0};
  double out_of_sync_ms_{0};
  double out_of_step_ms_{0};
  double readout_time_ms_{0};
  double exposure_time_ms_{0};
  bool no_color_{false};
  std::vector<CLI::Option*> given_;
};

}  // namespace fuse_flow::command_line
