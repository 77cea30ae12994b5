// Writes a recording of simulated depth cameras, with the exact surfaces behind it.

#include "io/rig_json.h"
#include "io/tool.h"
#include "io/view_files.h"
#include "simulation/truth.h"

#include <fuse_flow/impl/host/parallel.hpp>

#include <filesystem>

namespace {

namespace fs = std::filesystem;
using namespace fuse_flow;

struct Options {
  simulation::SimulationOptions simulation;
  double position_error_mm{0};
  double rotation_error_deg{0};
  double depth_bias_mm{0};
  double knock_mm{0};
  double knock_deg{0};
  double out_of_sync_ms{0};
  std::size_t frames{1};
  bool no_color{false};
  std::string output;
};

void makeFolder(const fs::path& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error) throw io::OutputError(path.string() + ": cannot be made: " + error.message());
}

void writeImages(const fs::path& folder, const io::LoadedFrame& measured, std::size_t frame) {
  const std::string file = io::frameStem(frame) + ".png";
  for (std::size_t k = 0; k < measured.rig.cameras.size(); ++k) {
    if (measured.rig.views[k].missing()) continue;  // a lost frame is a missing file
    const fs::path camera = folder / measured.rig.cameras[k].name;
    io::writeDepthPng((camera / "depth" / file).string(), measured.images[k].depth16);
    if (measured.rig.views[k].color) io::writeColorPng((camera / "color" / file).string(), measured.images[k].color);
  }
}

int run(Options options) {
  simulation::SimulationOptions& s = options.simulation;
  s.color = !options.no_color;
  s.faults.position_error = 0.001 * options.position_error_mm;
  s.faults.rotation_error = options.rotation_error_deg * 3.14159265358979323846 / 180;
  s.faults.depth_bias = 0.001 * options.depth_bias_mm;
  s.faults.knock = 0.001 * options.knock_mm;
  s.faults.knock_rotation = options.knock_deg * 3.14159265358979323846 / 180;
  s.faults.out_of_sync = 0.001 * options.out_of_sync_ms;
  simulation::Simulator simulator(s);
  const fs::path folder(options.output);
  if (fs::exists(folder) && !(fs::is_directory(folder) && fs::is_empty(folder)))
    throw io::OutputError(folder.string() + ": exists, must be a new or empty folder");
  std::vector<io::RigCamera> rig;
  for (const Camera& camera : simulator.cameras()) {
    rig.push_back({camera, simulator.sensor().depthScale()});
    makeFolder(folder / camera.name / "depth");
    if (s.color) makeFolder(folder / camera.name / "color");
  }
  simulation::writeTruth(options.output, simulator);
  io::LoadedFrame measured;
  for (std::size_t frame = 0; frame < options.frames && !io::interrupt_requested; ++frame) {
    simulator.measure(frame, measured);
    writeImages(folder, measured, frame);
    simulation::writeTruth(options.output, simulator, frame);
  }
  if (io::interrupt_requested) return io::kInterrupted;
  io::writeRigJson((folder / "rig.json").string(), rig);  // last: without it the folder is no recording
  std::cout << options.output << ": " << rig.size() << " cameras, " << options.frames << " frames, scene " << s.scene
            << ", sensor " << s.sensor << std::endl;
  return io::kSuccess;
}

std::string list(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  simulation::SimulationOptions& s = options.simulation;
  s.threads = host::resolveThreads(0);
  CLI::App app("Writes a recording of simulated depth cameras, with the exact surfaces in its folder truth.",
               "fuse_flow_simulate");
  app.add_option("--scene", s.scene, list(simulation::sceneNames()))->capture_default_str();
  app.add_option("--rig", s.rig, "ring-N or walls-N, N from 1 to 64, or with -narrow behind it")->capture_default_str();
  app.add_option("--sensor", s.sensor, list(simulation::sensorNames()))->capture_default_str();
  app.add_option("--frames", options.frames, "how many")->check(CLI::Range(1, 1000000))->capture_default_str();
  app.add_option("-o,--output", options.output, "folder of the recording; new or empty")->required();
  app.add_option("--seed", s.seed, "the same seed gives the same bytes")->capture_default_str();
  app.add_option("--scale", s.scale, "of the images' sides, (0, 2]")->capture_default_str();
  app.add_option("--fps", s.frames_per_second, "frames per second of the scene's time")->capture_default_str();
  app.add_flag("--no-color", options.no_color, "depth only");
  app.add_option("--position-error", options.position_error_mm, "calibrated positions are off by this, mm");
  app.add_option("--rotation-error", options.rotation_error_deg, "calibrated orientations are off by this, degrees");
  app.add_option("--depth-bias", options.depth_bias_mm, "each camera's depth is off by a constant in +- this, mm");
  app.add_option("--knock", options.knock_mm,
                 "from --knock-frame on the last camera stands this far from where it stood, mm");
  app.add_option("--knock-rotation", options.knock_deg, "and is turned by this, degrees");
  app.add_option("--knock-frame", s.faults.knock_frame, "when");
  app.add_option("--drop-rate", s.faults.drop_rate, "share of frames that a camera loses, [0, 1]");
  app.add_option("--out-of-sync", options.out_of_sync_ms, "each camera's time is off by a constant in +- this, ms");
  app.add_option("--threads", s.threads, "0: one per core")->check(CLI::Range(0, 1024));
  io::catchInterrupts();
  return io::runTool(app, argc, argv, [&] {
    s.threads = host::resolveThreads(s.threads);
    return run(options);
  });
}
