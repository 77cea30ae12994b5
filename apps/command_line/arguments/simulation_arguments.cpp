#include "command_line/arguments/simulation_arguments.h"

#include "command_line/arguments/option_checks.h"
#include "simulation/rig_layout.h"

#include <climits>

namespace fuse_flow::command_line {

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

SimulationArguments::SimulationArguments(CLI::App& app) {
  const std::string rigs = simulation::rigNames();
  add(app.add_option("--rig", options_.rig, rigs)->check(makeCheck(rigs, simulation::isRigName)));
  add(app.add_option("--sensor", options_.sensor, listed(simulation::sensorNames()))
          ->check(oneOf(simulation::sensorNames())));
  add(app.add_option("--seed", options_.seed, "the same seed gives the same bytes")->check(wholeNumber(0, INT_MAX)));
  add(app.add_option("--scale", options_.scale, "of the images' sides, (0, 2]")->check(positiveNumberUpTo(2)));
  given_.push_back(app.add_flag("--no-color", no_color_, "depth only"));
  given_.push_back(app.add_option("--position-error", position_error_mm_, "calibrated positions are off by this, mm")
                       ->check(nonNegativeNumber()));
  given_.push_back(
      app.add_option("--rotation-error", rotation_error_deg_, "calibrated orientations are off by this, degrees")
          ->check(nonNegativeNumber()));
  given_.push_back(
      app.add_option("--depth-bias", depth_bias_mm_, "each camera's depth is off by a constant in +- this, mm")
          ->check(nonNegativeNumber()));
  given_.push_back(app.add_option("--depth-distortion", depth_distortion_mm_,
                                  "each camera has a depth distortion of its own, of about this at 2 m, mm")
                       ->check(nonNegativeNumber()));
  given_.push_back(
      app.add_option("--bump", bump_mm_, "from --bump-frame on the last camera stands this far from where it stood, mm")
          ->check(nonNegativeNumber()));
  given_.push_back(
      app.add_option("--bump-rotation", bump_deg_, "and is turned by this, degrees")->check(nonNegativeNumber()));
  given_.push_back(app.add_option("--bump-frame", options_.faults.bump_frame, "when")->check(wholeNumber(0, INT_MAX)));
  given_.push_back(
      app.add_option("--drop-rate", options_.faults.drop_rate, "share of frames that a camera loses, [0, 1]")
          ->check(numberFromTo(0, 1)));
  given_.push_back(app.add_option("--marker", options_.marker,
                                  "side of an AprilTag that someone shows to the cameras, m; 0: nobody does")
                       ->check(nonNegativeNumber()));
  given_.push_back(
      app.add_option("--out-of-sync", out_of_sync_ms_, "each camera's time is off by a constant in +- this, ms")
          ->check(nonNegativeNumber()));
  given_.push_back(
      app.add_option("--out-of-step", out_of_step_ms_, "the cameras expose one after the other within this, ms")
          ->check(nonNegativeNumber()));
  given_.push_back(app.add_option("--readout-time", readout_time_ms_,
                                  "rolling shutter: from the first to the last row's exposure, ms, [0, 100]; 0: all "
                                  "rows at once")
                       ->check(numberFromTo(0, 100)));
  given_.push_back(app.add_option("--exposure-time", exposure_time_ms_,
                                  "how long each row is exposed, ms, [0, 100]: what moves meanwhile is blurred, in "
                                  "depth as each sensor does it; 0: an instant")
                       ->check(numberFromTo(0, 100)));
  given_.push_back(app.add_option("--image-noise", options_.faults.image.noise,
                                  "standard deviation of further noise of the colour images, grey levels, [0, 100]")
                       ->check(numberFromTo(0, 100)));
  given_.push_back(app.add_option("--exposure", options_.faults.image.exposure,
                                  "each camera's gain is off by a constant factor in 1 +- this, [0, 0.9], and its "
                                  "black level by up to 20 grey levels times this")
                       ->check(numberFromTo(0, 0.9)));
  given_.push_back(
      app.add_option(
             "--vignetting", options_.faults.image.vignetting,
             "share of the brightness lost at the corners of the colour images, each camera from 0 to this, [0, 1]")
          ->check(numberFromTo(0, 1)));
}

void SimulationArguments::add(CLI::Option* option) { given_.push_back(option->capture_default_str()); }

void SimulationArguments::need(CLI::Option* option) {
  for (CLI::Option* mine : given_) mine->needs(option);
}

simulation::SimulationOptions SimulationArguments::options() const {
  simulation::SimulationOptions result = options_;
  result.color = !no_color_;
  result.faults.position_error = 0.001 * position_error_mm_;
  result.faults.rotation_error = rotation_error_deg_ * 3.14159265358979323846 / 180;
  result.faults.depth_bias = 0.001 * depth_bias_mm_;
  result.faults.depth_distortion = 0.001 * depth_distortion_mm_;
  result.faults.bump = 0.001 * bump_mm_;
  result.faults.bump_rotation = bump_deg_ * 3.14159265358979323846 / 180;
  result.faults.out_of_sync = 0.001 * out_of_sync_ms_;
  result.faults.out_of_step = 0.001 * out_of_step_ms_;
  result.faults.readout_time = 0.001 * readout_time_ms_;
  result.faults.exposure_time = 0.001 * exposure_time_ms_;
  return result;
}

}  // namespace fuse_flow::command_line
