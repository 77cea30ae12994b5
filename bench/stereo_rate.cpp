// How long multi-view stereo takes on a GPU, alone and with the fusion behind it: the table of doc/notes/stereo.md.
//
//   fuse_flow_stereo_bench [--runs N] [--sources N] [--fine-passes N] [--compare] [CAMERASxWIDTHxHEIGHT …]
//
// --compare runs the CPU too, and counts the pixels whose depth is not the same to the last bit.
#include "median.h"
#include "room.h"

#include <fuse_flow/gpu/fuse_flow.h>
#include <fuse_flow/gpu/stereo/multi_view_stereo.h>
#include <fuse_flow/point_types.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace fuse_flow;
using Clock = std::chrono::steady_clock;

double since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

struct Options {
  int runs{20};
  bool compare{false};
  StereoParameters parameters;
  std::vector<std::string> sizes;
};

Options parse(int argc, char** argv) {
  Options options;
  for (int k = 1; k < argc; ++k) {
    const std::string argument = argv[k];
    const auto number = [&] {
      if (k + 1 >= argc) throw std::runtime_error(argument + " needs a number");
      return std::atoi(argv[++k]);
    };
    if (argument == "--runs") {
      options.runs = number();
    } else if (argument == "--sources") {
      options.parameters.max_sources = number();
    } else if (argument == "--fine-passes") {
      options.parameters.fine_passes = number();
    } else if (argument == "--coarse-passes") {
      options.parameters.coarse_passes = number();
    } else if (argument == "--compare") {
      options.compare = true;
    } else {
      options.sizes.push_back(argument);
    }
  }
  if (options.sizes.empty()) options.sizes = {"4x640x480", "8x640x480"};
  return options;
}

/** \brief Milliseconds, the median over the runs after three that warm up. */
template <typename Action>
double timeOf(int runs, const Action& action) {
  std::vector<double> times;
  for (int k = 0; k < runs + 3; ++k) {
    const Clock::time_point start = Clock::now();
    action();
    if (k >= 3) times.push_back(since(start));
  }
  return bench::median(times);
}

void compare(const StereoParameters& parameters, const RigFrame& frame, const StereoFrame& of_gpu) {
  MultiViewStereo<> stereo;
  stereo.setParameters(parameters);
  StereoFrame of_cpu;
  stereo.estimate(frame, of_cpu);
  std::size_t all = 0, other = 0;
  for (std::size_t k = 0; k < of_cpu.views.size(); ++k)
    for (std::size_t pixel = 0; pixel < of_cpu.views[k].depth.size(); ++pixel) {
      ++all;
      const float a = of_cpu.views[k].depth[pixel], b = of_gpu.views[k].depth[pixel];
      other += std::memcmp(&a, &b, sizeof(a)) != 0 ? 1 : 0;
    }
  std::printf("  CPU %.0f ms; %zu of %zu pixels have another depth\n", of_cpu.total_ms, other, all);
}

void measure(const Options& options, const std::string& size) {
  int cameras = 0, width = 0, height = 0;
  if (std::sscanf(size.c_str(), "%dx%dx%d", &cameras, &width, &height) != 3)
    throw std::runtime_error("'" + size + "' is no CAMERASxWIDTHxHEIGHT");
  const bench::Room room(cameras, width, height, true);
  gpu::PinnedBuffer<char> memory;
  memory.resize(room.bytes());
  const RigFrame frame = room.render(memory.data(), 1);

  MultiViewStereo<device::Thrust> stereo;
  stereo.setParameters(options.parameters);
  RigFrame found;
  const double alone = timeOf(options.runs, [&] {
    stereo.estimateOnDevice(frame, found);
    stereo.wait();
  });
  FuseFlow<PointFused, device::Thrust> fusion;
  FuseFlowParameters parameters = FuseFlowParameters::estimatedDepth();
  parameters.agreement.min_views = std::min(parameters.agreement.min_views, cameras - 1);
  fusion.setParameters(parameters);
  std::size_t points = 0;
  const double both = timeOf(options.runs, [&] {
    stereo.estimateOnDevice(frame, found);
    points = fusion.fusePinned(found).size;
  });
  StereoFrame downloaded;
  const double to_host = timeOf(options.runs, [&] { stereo.estimate(frame, downloaded); });
  stereo.setNormals(false);
  const double depth_alone = timeOf(options.runs, [&] { stereo.estimate(frame, downloaded); });
  std::size_t agreeing = 0;
  for (const StereoView& view : downloaded.views) agreeing += view.agreeing;
  std::printf(
      "%s: stereo %.2f ms, with download %.2f ms (%.2f without normals), with fusion %.2f ms (%.1f frames/s, %zu "
      "points); "
      "%.1f %% agreed\n",
      size.c_str(), alone, to_host, depth_alone, both, 1000 / both, points,
      100.0 * static_cast<double>(agreeing) / static_cast<double>(room.pixels()));
  if (options.compare) compare(options.parameters, frame, downloaded);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const Options options = parse(argc, argv);
    for (const std::string& size : options.sizes) measure(options, size);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "fuse_flow_stereo_bench: %s\n", error.what());
    return 1;
  }
}
