#pragma once

/** \file
 *  \brief The recording of `./build.sh demo` in small: four structured-light cameras, calibrated to 2 mm and 0.1 degrees, around a
 *  person who walks through a room. The same bytes on every machine. */

#include "simulation/simulator.h"

#include <cstddef>
#include <vector>

namespace simulated_recording {

/** \brief \param scale of the images' sides, which are 640 × 480 at 1 */
inline fuse_flow::simulation::SimulationOptions options(double scale) {
  fuse_flow::simulation::SimulationOptions options;
  options.scene = "person";
  options.rig = "ring-4";
  options.sensor = "structured_light";
  options.scale = scale;
  options.frames_per_second = 5;
  options.faults.position_error = 0.002;
  options.faults.rotation_error = 0.1 * 0.017453292519943295;
  return options;
}

/** \brief Its first frames. */
inline std::vector<fuse_flow::io::LoadedFrame> frames(fuse_flow::simulation::Simulator& simulator, std::size_t count) {
  std::vector<fuse_flow::io::LoadedFrame> frames(count);
  for (std::size_t frame = 0; frame < count; ++frame) simulator.measure(frame, frames[frame]);
  return frames;
}

/** \brief The first frames of a simulator that nobody needs afterwards. */
inline std::vector<fuse_flow::io::LoadedFrame> frames(double scale, std::size_t count) {
  fuse_flow::simulation::Simulator simulator(options(scale));
  return frames(simulator, count);
}

}  // namespace simulated_recording
