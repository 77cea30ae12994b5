// Writes a recording of simulated depth cameras, with the exact surfaces behind it.

#include "command_line/arguments/option_checks.h"
#include "command_line/arguments/simulation_arguments.h"
#include "command_line/tool.h"
#include "evaluation/truth.h"

#include <fuse_flow/impl/host/parallel.hpp>
#include <fuse_flow/recordings/rig_writer.h>

#include <filesystem>

namespace {

namespace fs = std::filesystem;
using namespace fuse_flow;

struct Options {
  simulation::SimulationOptions simulation;
  std::size_t frames{1};
  bool depth{true};  ///< false: colour images alone are written
  std::string output;
};

/** \brief Of cameras that measure no depth. */
void removeDepth(io::RigDescription& rig) {
  for (io::RigCamera& entry : rig.cameras) entry.has_depth_scale = false;
}
void removeDepth(RigFrame& frame) {
  for (DepthView& view : frame.views) view.depth16 = {};
}

int run(const Options& options) {
  const simulation::SimulationOptions& s = options.simulation;
  simulation::Simulator simulator(s);
  const fs::path folder(options.output);
  if (fs::exists(folder) && !(fs::is_directory(folder) && fs::is_empty(folder)))
    throw io::OutputError(folder.string() + ": exists, must be a new or empty folder");
  io::RigDescription rig = simulator.rig();
  if (!options.depth) removeDepth(rig);
  const io::RigWriter writer(options.output, std::move(rig), s.color);
  simulation::writeTruth(options.output, simulator);
  io::LoadedFrame measured;
  for (std::size_t frame = 0; frame < options.frames && !io::interrupt_requested; ++frame) {
    simulator.measure(frame, measured);
    if (!options.depth) removeDepth(measured.rig);
    writer.write(frame, measured);
    simulation::writeTruth(options.output, simulator, frame);
  }
  if (io::interrupt_requested) return command_line::kInterrupted;
  writer.finish();
  std::cout << options.output << ": " << simulator.cameras().size() << " cameras, " << options.frames
            << " frames, scene " << s.scene << ", sensor " << s.sensor << std::endl;
  return command_line::kSuccess;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  simulation::SimulationOptions defaults;
  CLI::App app("Writes a recording of simulated depth cameras, with the exact surfaces in its folder truth.",
               "fuse_flow_simulate");
  app.add_option("--scene", defaults.scene, command_line::listed(simulation::sceneNames()))
      ->check(command_line::oneOf(simulation::sceneNames()))
      ->capture_default_str();
  command_line::SimulationArguments rig(app);
  app.add_option("--frames", options.frames, "how many")->check(CLI::Range(1, 1000000))->capture_default_str();
  app.add_flag("!--no-depth", options.depth, "colour images alone, as of cameras without depth")
      ->excludes(app.get_option("--no-color"));
  app.add_option("-o,--output", options.output, "folder of the recording; new or empty")
      ->check(command_line::path())
      ->required();
  app.add_option("--fps", defaults.frames_per_second, "frames per second of the scene's time")
      ->check(command_line::positiveNumberUpTo(1e6))
      ->capture_default_str();
  app.add_option("--threads", defaults.threads, "0: one per core")->check(CLI::Range(0, 1024));
  defaults.threads = 0;
  io::catchInterrupts();
  return command_line::runTool(app, argc, argv, [&] {
    options.simulation = rig.options();
    options.simulation.scene = defaults.scene;
    options.simulation.frames_per_second = defaults.frames_per_second;
    options.simulation.threads = host::resolveThreads(defaults.threads);
    return run(options);
  });
}
