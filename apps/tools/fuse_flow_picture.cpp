// Draws clouds side by side, from the same viewpoint, into a PNG.

#include "clouds/cloud_io.h"
#include "command_line/arguments/option_checks.h"
#include "command_line/tool.h"
#include "drawing/clouds.h"
#include "drawing/display.h"
#include "recordings/files/file_io.h"
#include "recordings/images/image_io.h"

#include <fuse_flow/recordings/input_files.h>

#include <pcl/point_types.h>

#include <cmath>

namespace {

using namespace fuse_flow;

struct Options {
  std::vector<std::string> clouds;
  std::string output;
  drawing::Viewpoint viewpoint;
  std::vector<int> size{1600, 800};
};

drawing::ColoredPoints readColored(const std::string& path) {
  pcl::PointCloud<pcl::PointXYZRGB> cloud;
  io::readCloud(path, cloud);
  drawing::ColoredPoints points;
  for (const pcl::PointXYZRGB& p : cloud) {
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) continue;
    points.positions.emplace_back(p.x, p.y, p.z);
    points.colors.push_back({p.r, p.g, p.b});
  }
  return points;
}

int run(Options options) {
  io::InputFiles(options.clouds).refuseToReplace("-o", options.output);
  std::vector<drawing::ColoredPoints> clouds;
  for (const std::string& path : options.clouds) clouds.push_back(readColored(path));
  drawing::requireDisplay("fuse_flow_picture");
  options.viewpoint.width = options.size[0];
  options.viewpoint.height = options.size[1];
  io::writeColorPng(options.output, drawing::drawClouds(clouds, options.viewpoint));
  return command_line::kSuccess;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Draws clouds side by side, from one viewpoint, into a PNG. Needs a display, or xvfb-run.",
               "fuse_flow_picture");
  app.add_option("cloud", options.clouds, "PLY or PCD files")->required();
  app.add_option("-o,--output", options.output, "PNG file")->check(command_line::path())->required();
  app.add_option("--from", options.viewpoint.from, "where the viewer stands, m; default: outside the bounding box")
      ->expected(3)
      ->check(command_line::finiteNumber());
  app.add_option("--at", options.viewpoint.at, "what the viewer looks at, m; default: the middle of the first cloud")
      ->expected(3)
      ->check(command_line::finiteNumber());
  app.add_option("--up", options.viewpoint.up, "which way is up")
      ->expected(3)
      ->check(command_line::finiteNumber())
      ->capture_default_str();
  app.add_option("--size", options.size, "width and height, pixels")
      ->expected(2)
      ->check(command_line::wholeNumber(1, 16384))
      ->capture_default_str();
  app.add_option("--zoom", options.viewpoint.zoom, "narrows the view")
      ->check(command_line::positiveNumber())
      ->capture_default_str();
  app.add_option("--point-size", options.viewpoint.point_size, "pixels")
      ->check(command_line::positiveNumberUpTo(1000))
      ->capture_default_str();
  return command_line::runTool(app, argc, argv, [&] { return run(options); });
}
