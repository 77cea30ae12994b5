// Prints how well clouds, whoever made them, agree with the views they came from.

#include "io/cloud_io.h"
#include "io/file_io.h"
#include "io/option_checks.h"
#include "io/recording.h"
#include "io/report.h"
#include "io/tool.h"

#include <pcl/point_types.h>

#include <limits>

namespace {

using namespace fuse_flow;

struct Options {
  std::string recording;
  std::vector<std::string> clouds;
  std::size_t frame{0};
  std::string json;
  unsigned int threads{0};
  QualityParameters quality;
  io::RecordingOptions recording_options;
};

int run(const Options& options) {
  if (!(options.quality.min_range < options.quality.max_range))
    throw io::OptionError("--min-range must be below --max-range");
  const std::unique_ptr<io::Recording> recording = io::openRecording({options.recording}, options.recording_options);
  if (options.frame >= recording->frameCount())
    throw io::OptionError("--frame " + std::to_string(options.frame) + ": the recording has " +
                          std::to_string(recording->frameCount()) + " frames, counted from 0");
  io::LoadedFrame loaded;
  recording->read(options.frame, loaded);
  std::size_t width = 5;
  for (const std::string& path : options.clouds) width = std::max(width, path.size());
  nlohmann::json json;
  for (const std::string& path : options.clouds) {
    pcl::PointCloud<pcl::PointXYZ> cloud;
    io::readCloud(path, cloud);
    if (json.empty()) std::cout << io::qualityHeader(width) << '\n';
    const Quality quality = multiCameraConsistency(cloud, loaded.rig, options.quality, options.threads);
    std::cout << io::qualityRow(path, width, quality) << std::endl;
    json[path] = io::qualityJson(quality);
  }
  if (!options.json.empty()) io::writeFile(options.json, json.dump(2) + "\n");
  return io::kSuccess;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Measures how well clouds agree with the depth views of one frame of a recording.",
               "fuse_flow_evaluate");
  app.add_option("recording", options.recording, "as fuse_flow_fuse reads it")->required();
  app.add_option("cloud", options.clouds, "PLY or PCD files in the world frame")->required();
  app.add_option("--frame", options.frame, "frame of the recording to compare with")
      ->check(io::wholeNumber(0, std::numeric_limits<int>::max()))
      ->capture_default_str();
  app.add_option("--views", options.recording_options.views, "frames that act as the cameras of one instant");
  app.add_option("--slide", options.recording_options.slide, "move those views on by this many frames a frame")
      ->check(io::wholeNumber(0, std::numeric_limits<int>::max()));
  app.add_option("--depth-scale", options.recording_options.depth_scale, "metres per unit of depth")
      ->check(io::positiveNumber());
  app.add_option("--visibility", options.quality.visibility, "largest |z - D| at which a view sees a point, m")
      ->check(io::positiveNumber())
      ->capture_default_str();
  app.add_option("--coverage-radius", options.quality.coverage_radius, "m")
      ->check(io::positiveNumber())
      ->capture_default_str();
  app.add_option("--min-range", options.quality.min_range, "m")->check(io::nonNegativeNumber())->capture_default_str();
  app.add_option("--max-range", options.quality.max_range, "m")->check(io::positiveNumber())->capture_default_str();
  app.add_option("--json", options.json, "write the figures to this file too");
  app.add_option("--threads", options.threads, "0: one per core")->check(io::threadCount())->capture_default_str();
  return io::runTool(app, argc, argv, [&] { return run(options); });
}
