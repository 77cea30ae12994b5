// How long a cloud in device memory takes to become the bytes of a stream: fuse_flow_gpu_stream_bench [--runs N] [CAMERASxWIDTHxHEIGHT…].
// Clouds are fused of a made-up room. Milliseconds are medians; the stages are measured by themselves, in frames of their own.

#include "gpu_frames.h"
#include "stream/gpu/device_frame_encoder.h"

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <map>
#include <string>
#include <vector>

namespace {

using namespace fuse_flow;

void measure(const char* name, const stream::CloudView& cloud, const bench::Cloud& here,
             const stream::EncodingOptions& options, int runs) {
  stream::DeviceFrameEncoder encoder(options);
  stream::FrameEncoder on_cpu(options);
  const double points = static_cast<double>(cloud.size);
  double bits = 0;
  std::vector<double> times;
  for (int run = -3; run < runs; ++run) {
    const bench::Clock::time_point start = bench::Clock::now();
    const auto frame = encoder.encode(cloud, {});
    if (run >= 0) times.push_back(bench::since(start));
    bits = 8 * static_cast<double>(frame->bytes()) / points;
  }
  std::printf("%-36s %8zu points  %6.2f ms  %6.2f bits a point, by the CPU %.2f\n", name, cloud.size,
              bench::median(times), bits, 8 * static_cast<double>(on_cpu.encode(here, {})->bytes()) / points);
  std::map<std::string, std::vector<double>> of_stages;
  encoder.times().enabled = true;
  for (int run = 0; run < runs; ++run) {
    encoder.encode(cloud, {});
    for (const gpu::StageTimes::Stage& stage : encoder.times().stages()) of_stages[stage.name].push_back(stage.ms);
  }
  for (const gpu::StageTimes::Stage& stage : encoder.times().stages())
    std::printf("  %-12s %7.3f ms\n", stage.name, bench::median(of_stages[stage.name]));
}

void measure(const bench::Size& size, int runs) {
  const bench::Frames frames(size);
  bench::Gpu fusion;
  const gpu::PointSpan<bench::Point> points = fusion.fuseOnDevice(frames.at(0));
  bench::Cloud here;
  bench::Gpu again;
  again.fuse(frames.at(0), here);
  const stream::CloudView cloud = stream::viewOf(points.points, points.size);
  std::printf("%s\n", size.name().c_str());
  stream::EncodingOptions options;
  measure("colour, confidence, number of views", cloud, here, options, runs);
  options.confidence = options.view_count = false;
  measure("colour", cloud, here, options, runs);
}

}  // namespace

int main(int argc, char** argv) try {
  int runs = 50;
  std::vector<bench::Size> sizes;
  for (int k = 1; k < argc; ++k) {
    bench::Size size{};
    if (std::string(argv[k]) == "--runs" && k + 1 < argc) {
      runs = std::atoi(argv[++k]);
    } else if (std::sscanf(argv[k], "%dx%dx%d", &size.cameras, &size.width, &size.height) == 3) {
      sizes.push_back(size);
    } else {
      std::fprintf(stderr, "usage: fuse_flow_gpu_stream_bench [--runs N] [CAMERASxWIDTHxHEIGHT…]\n");
      return 2;
    }
  }
  if (sizes.empty()) sizes = {{4, 640, 480}, {8, 640, 480}};
  for (const bench::Size& size : sizes) measure(size, runs);
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
