// Writes a recording as organised PCD files, a folder a camera: what pcl::PCDGrabber plays and pcl_viewer shows.

#include "clouds/cloud_io.h"
#include "clouds/other_clouds.h"
#include "command_line/arguments/option_checks.h"
#include "command_line/arguments/recording_arguments.h"
#include "command_line/arguments/stereo_arguments.h"
#include "command_line/tool.h"
#include "input_checks/input_checks.h"
#include "recordings/files/file_io.h"
#include "recordings/still_there.h"

#include <fuse_flow/recordings/input_files.h>
#include <fuse_flow/recordings/organized_cloud.h>
#include <fuse_flow/recordings/recording.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <set>

namespace {

namespace fs = std::filesystem;
using namespace fuse_flow;

struct Options {
  std::vector<std::string> inputs;
  io::RecordingOptions recording;
  io::StereoOptions stereo;
  std::optional<double> frames_per_second;
  std::string output;
};

int run(const Options& options) {
  const std::unique_ptr<io::Recording> recording =
      command_line::openRecording("fuse_flow_export", options.inputs, options.recording, options.stereo);
  io::InputFiles inputs(recording->inputs());
  const io::StillThere still_there(*recording);
  io::LoadedFrame loaded;
  io::OrganizedCloud cloud;
  std::size_t files = 0;
  std::map<std::string, std::size_t> written;  // and of which frame
  io::InputChecks checks("concatenate", FuseFlowParameters(), {});
  for (const std::size_t frame : recording->frames()) {
    if (io::interrupt_requested) break;
    recording->read(frame, loaded);
    still_there.check(loaded);
    checks.look(loaded);
    const bool timed = recording->framesPerSecond() || loaded.rig.stamp;
    const auto stamp = timed && !options.frames_per_second
                           ? static_cast<long long>(loaded.rig.stamp)
                           : std::llround(1e6 * static_cast<double>(frame) / options.frames_per_second.value_or(30));
    char name[32];
    std::snprintf(name, sizeof(name), "%012lld.pcd", stamp);
    for (std::size_t k = 0; k < loaded.rig.views.size(); ++k) {
      if (loaded.rig.views[k].missing()) continue;
      const fs::path folder = fs::path(options.output) / recording->viewName(k);
      inputs.refuseToReplace("-o", (folder / name).string());
      io::makeFolder(folder.string());
      const Camera& camera = loaded.rig.cameras[k];
      io::toOrganizedCloud(camera, loaded.rig.views[k], cloud);
      cloud.sensor_origin_.head<3>() = camera.T_world_camera.translation().cast<float>();
      cloud.sensor_orientation_ = Eigen::Quaterniond(camera.T_world_camera.linear()).cast<float>();
      const std::string path = (folder / name).string();
      if (const auto [other, is_new] = written.emplace(path, frame); !is_new)
        throw io::OutputError(path + (other->second == frame
                                          ? ": two cameras have this name, and one would replace the other"
                                          : ": frame " + std::to_string(frame) +
                                                " has the time of one before it, and would replace it; --fps gives "
                                                "each a time of its own"));
      io::writeCloud(path, cloud);
      ++files;
    }
  }
  std::vector<std::string> said = checks.complaints();
  std::set<std::string> folders;
  for (const Camera& camera : recording->cameras()) folders.insert((fs::path(options.output) / camera.name).string());
  if (std::string others = io::otherClouds(options.output, {folders.begin(), folders.end()},
                                           [&](const std::string& path) { return written.count(path) > 0; });
      !others.empty())
    said.push_back(std::move(others));
  std::cout << options.output << ": " << files << " clouds of " << recording->cameras().size() << " cameras"
            << std::endl;
  for (const std::string& line : said) std::cout << "  " << line << "\n";
  return io::interrupt_requested ? command_line::kInterrupted : command_line::kSuccess;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Writes a recording as organised PCD files, a folder a camera, named by time in microseconds.",
               "fuse_flow_export");
  app.add_option("input", options.inputs, "a rig recording, or a 7-Scenes, TUM RGB-D, Redwood, MVSNet or COLMAP folder")
      ->required();
  app.add_option("-o,--output", options.output, "folder of the folders")->check(command_line::path())->required();
  app.add_option("--fps", options.frames_per_second, "frames per second; default: the recording's own times, else 30")
      ->check(command_line::numberFromTo(1e-3, 1e6));
  app.add_option("--views", options.recording.views, "cameras, or frames that act as such: 0,60,120 or A:B:STEP")
      ->multi_option_policy(CLI::MultiOptionPolicy::Join);
  app.add_option("--slide", options.recording.slide, "move those frames on by this many, again and again")
      ->check(CLI::Range(0, 1000000));
  command_line::addCalibrationOptions(app, options.recording);
  command_line::StereoArguments stereo(app);
  io::catchInterrupts();
  return command_line::runTool(app, argc, argv, [&] {
    options.stereo = stereo.options("fuse_flow_export");
    return run(options);
  });
}
