// The GPU pipeline over the number of cameras: device time of every stage beside the time that its bytes take at the measured
// copy bandwidth, latency, sustained rate, and the CPU pipeline on the same frames.
//   fuse_flow_gpu_bench [--quick] [--no-cpu] [--dump FOLDER] [--unusual] [CAMERASxWIDTHxHEIGHT …]
// With --unusual: frames far from what the pipeline is laid out for, beside an ordinary one.

#include "room.h"

#include <fuse_flow/gpu/fuse_flow.h>
#include <fuse_flow/point_types.h>

#include <cstdio>
#include <fstream>
#include <map>

namespace {

using namespace fuse_flow;
using Clock = std::chrono::steady_clock;
using Gpu = FuseFlow<PointFused, device::Thrust>;

constexpr int kFrames = 3;  // different ones, in turn

double since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

/** \brief Read and written bytes per second, in GB/s, of a large copy within the device; up to and down from it, one way. */
struct Bandwidth {
  double device{0}, up{0}, down{0};
};

Bandwidth measureBandwidth() {
  Bandwidth result;
  gpu::Execution run;
  const std::size_t n = std::size_t{1} << 28;
  gpu::DeviceBuffer<std::uint32_t> a, b;
  gpu::PinnedBuffer<std::uint32_t> pinned;
  a.resize(n);
  b.resize(n);
  pinned.resize(n);
  run.fill(a.data(), n, 1);
  const auto rate = [&](std::uint32_t* to, const std::uint32_t* from, double bytes) {
    std::vector<double> times;
    for (int k = 0; k < 7; ++k) {
      run.wait();
      const Clock::time_point start = Clock::now();
      run.copy(to, from, n);
      run.wait();
      times.push_back(since(start));
    }
    return bytes / median(times) * 1e-6;
  };
  const double size = static_cast<double>(n) * sizeof(std::uint32_t);
  result.device = rate(b.data(), a.data(), 2 * size);
  result.down = rate(pinned.data(), a.data(), size);
  result.up = rate(a.data(), pinned.data(), size);
  return result;
}

struct Size {
  int cameras, width, height;
};

struct Options {
  bool quick{false};
  bool cpu{true};
  bool unusual{false};
  std::string dump;
  std::vector<Size> sizes;
};

/** \brief The first frame as files that bench/torch_voxel_average.py reads. */
void dump(const std::string& folder, const RigFrame& frame, const char* memory, std::size_t bytes) {
  std::ofstream(folder + "/images.bin", std::ios::binary).write(memory, static_cast<std::streamsize>(bytes));
  std::ofstream rig(folder + "/rig.txt");
  rig.precision(17);
  for (const Camera& camera : frame.cameras) {
    const Intrinsics& K = camera.intrinsics;
    rig << K.width << ' ' << K.height << ' ' << K.fx << ' ' << K.fy << ' ' << K.cx << ' ' << K.cy;
    for (int row = 0; row < 3; ++row)
      for (int col = 0; col < 4; ++col) rig << ' ' << camera.T_world_camera.matrix()(row, col);
    rig << '\n';
  }
}

void printStages(const std::map<std::string, std::vector<double>>& ms,
                 const std::vector<gpu::StageTimes::Stage>& stages, const Bandwidth& bandwidth) {
  std::printf("  %-26s %9s %9s %9s %7s\n", "stage", "ms", "MB", "bound ms", "share");
  double device = 0, bound = 0;
  for (const auto& stage : stages) {
    const std::string name = stage.name;
    const bool bus = name == "upload" || name == "download";
    const double time = median(ms.at(name));
    const double limit = bus ? stage.bytes / 2 / ((name == "upload" ? bandwidth.up : bandwidth.down) * 1e6)
                             : stage.bytes / (bandwidth.device * 1e6);
    std::printf("  %-26s %9.4f %9.2f %9.4f %6.0f%%\n", stage.name, time, stage.bytes * 1e-6, limit, 100 * limit / time);
    if (bus) continue;
    device += time;
    bound += limit;
  }
  std::printf("  %-26s %9.4f %9s %9.4f %6.0f%%   (without the bus; %.2f x the bound)\n", "device", device, "", bound,
              100 * bound / device, device / bound);
}

/** \brief The sum of the stages' times, without the bus. */
double deviceTime(Gpu& fusion) {
  double sum = 0;
  for (const auto& stage : fusion.stageTimes().stages())
    if (std::string(stage.name) != "upload" && std::string(stage.name) != "download") sum += stage.ms;
  return sum;
}

void run(const Size& size, const Options& options, const Bandwidth& bandwidth) {
  const bench::Room room(size.cameras, size.width, size.height);
  gpu::PinnedBuffer<char> pinned[kFrames];
  std::vector<RigFrame> frames;
  for (int k = 0; k < kFrames; ++k) {
    pinned[k].resize(room.bytes());
    frames.push_back(room.render(pinned[k].data(), static_cast<std::uint32_t>(k)));
  }
  if (!options.dump.empty()) dump(options.dump, frames[0], pinned[0].data(), room.bytes());
  const double megapixels = 1e-6 * static_cast<double>(room.pixels());
  const int repeats = options.quick ? 5 : megapixels > 10 ? 20 : 60;

  // One frame at a time, stage by stage.
  std::map<std::string, std::vector<double>> stage_ms;
  std::vector<gpu::StageTimes::Stage> stages;
  std::vector<double> device_ms, latency_ms, cloud_ms;
  std::size_t points = 0, bytes = 0;
  {
    const gpu::OwnStream stream;
    Gpu fusion;
    fusion.setStream(stream.get());
    for (int k = 0; k < 4; ++k) points = fusion.fusePinned(frames[static_cast<std::size_t>(k % kFrames)]).size;
    fusion.stageTimes().enabled = true;
    for (int k = 0; k < repeats; ++k) {
      fusion.fusePinned(frames[static_cast<std::size_t>(k % kFrames)]);
      stages = fusion.stageTimes().stages();
      for (const auto& stage : stages) stage_ms[stage.name].push_back(stage.ms);
      device_ms.push_back(deviceTime(fusion));
    }
    fusion.stageTimes().enabled = false;
    pcl::PointCloud<PointFused> cloud;
    for (int k = 0; k < repeats; ++k) {
      const Clock::time_point start = Clock::now();
      fusion.fusePinned(frames[static_cast<std::size_t>(k % kFrames)]);
      latency_ms.push_back(since(start));
    }
    fusion.fuse(frames[0], cloud);
    for (int k = 0; k < repeats; ++k) {
      const Clock::time_point start = Clock::now();
      fusion.fuse(frames[static_cast<std::size_t>(k % kFrames)], cloud);
      cloud_ms.push_back(since(start));
    }
    bytes = fusion.getDeviceBytes();
  }

  // Several in flight.
  const auto sustained = [&](std::size_t lanes, bool to_cloud) {
    Gpu fusion;
    fusion.setFramesInFlight(lanes);
    fusion.setCopyAhead(to_cloud);
    pcl::PointCloud<PointFused> cloud;
    std::size_t submitted = 0;
    const auto take = [&] {
      if (to_cloud) {
        fusion.next(cloud);
      } else {
        fusion.nextPinned([](const gpu::PointSpan<PointFused>&, std::uint64_t) {});
      }
    };
    const auto frame = [&]() -> const RigFrame& { return frames[submitted++ % kFrames]; };
    for (std::size_t k = 0; k < 2 * lanes; ++k) {
      if (fusion.inFlight() == lanes) take();
      fusion.submit(frame());
    }
    const int count = 5 * repeats;
    const Clock::time_point start = Clock::now();
    for (int k = 0; k < count; ++k) {
      take();
      fusion.submit(frame());
    }
    const double rate = 1e3 * count / since(start);
    while (fusion.inFlight() > 0) take();
    return rate;
  };
  const auto bestOf = [&](bool to_cloud) {
    std::pair<double, std::size_t> best{0, 0};
    for (const std::size_t lanes : {2u, 3u, 4u, 6u, 8u, 12u, 16u})
      best = std::max(best, {sustained(lanes, to_cloud), lanes});
    return best;
  };
  const auto [best, best_lanes] = bestOf(false);
  const auto [best_cloud, best_cloud_lanes] = bestOf(true);

  double cpu_ms = 0;
  if (options.cpu) {
    FuseFlow<PointFused> fusion;
    pcl::PointCloud<PointFused> cloud;
    std::vector<double> times;
    fusion.fuse(frames[0], cloud);
    for (int k = 0; k < (megapixels > 10 ? 2 : 5); ++k) {
      const Clock::time_point start = Clock::now();
      fusion.fuse(frames[static_cast<std::size_t>(k % kFrames)], cloud);
      times.push_back(since(start));
    }
    cpu_ms = median(times);
  }
  std::printf(
      "%dx%dx%d  %.2f Mpixel  %zu points  device %.4f ms (%.1f us a camera, %.3f ns a pixel)  latency pinned %.3f ms, "
      "to "
      "a cloud %.3f ms  sustained pinned %.1f fps (%zu in flight), to clouds %.1f fps (%zu in flight)  CPU %.2f ms  "
      "%.0f MB on the "
      "device\n",
      size.cameras, size.width, size.height, megapixels, points, median(device_ms),
      1e3 * median(device_ms) / size.cameras, median(device_ms) / megapixels, median(latency_ms), median(cloud_ms),
      best, best_lanes, best_cloud, best_cloud_lanes, cpu_ms, 1e-6 * static_cast<double>(bytes));
  printStages(stage_ms, stages, bandwidth);
  std::fflush(stdout);
}

/** \brief A frame of the room in float metres, all of it larger or smaller. */
struct ScaledRoom {
  gpu::PinnedBuffer<float> depth;
  RigFrame frame;

  ScaledRoom(const bench::Room& room, double scale, bool scattered = false) {
    std::vector<char> images(room.bytes());
    frame = room.render(images.data(), 0);
    depth.resize(room.pixels());
    const auto* millimetres = reinterpret_cast<const std::uint16_t*>(images.data());
    for (std::size_t k = 0; k < room.pixels(); ++k) {
      // Scattered: no two pixels that are neighbours in the image are so in space.
      const double metres = scattered ? 1.5 + 0.01 * static_cast<double>(k * 7919 % 397) : 0.001 * millimetres[k];
      depth.data()[k] = static_cast<float>(scale * metres);
    }
    for (std::size_t i = 0; i < frame.views.size(); ++i) {
      frame.cameras[i].T_world_camera.translation() *= scale;
      const auto& K = frame.cameras[i].intrinsics;
      frame.views[i] = DepthView();
      frame.views[i].depth32 = {depth.data() + i * room.pixelsOfCamera(), K.width, K.height};
    }
  }
};

/** \brief 8 × 640×480, float depth without colour: times relative to those of the ordinary frame. */
void runUnusual() {
  const bench::Room room(8, 640, 480);
  const ScaledRoom ordinary(room, 1), tiny(room, 0.1 / 6), vast(room, 1000.0 / 6), scattered(room, 1, true),
      empty(room, 0);
  const ScaledRoom small(bench::Room(1, 320, 240), 1);

  FuseFlowParameters usual, of_tiny, of_vast, of_scattered, of_one_cell;
  const auto scaleRange = [](FuseFlowParameters& parameters, float scale) {
    parameters.preprocessing.min_range *= scale;
    parameters.preprocessing.max_range *= scale;
  };
  scaleRange(of_tiny, 0.1f / 6);
  scaleRange(of_vast, 1000.0f / 6);
  of_vast.max_noise = of_scattered.max_noise = 0;  // which would drop what is meant to be a load
  of_scattered.use_measurement_confidence = false;
  of_scattered.aggregation.cell_size = of_scattered.aggregation.min_cell_size = 0.004f;
  of_one_cell.aggregation.cell_size = 16.0f;
  struct Case {
    const char* name;
    std::vector<const RigFrame*> frames;
    const FuseFlowParameters* parameters;
  };
  const Case cases[] = {
      {"ordinary", {&ordinary.frame}, &usual},
      {"0.1 m across", {&tiny.frame}, &of_tiny},
      {"1 km across", {&vast.frame}, &of_vast},
      {"every pixel a cell of its own", {&scattered.frame}, &of_scattered},
      {"one coarse cell a room", {&ordinary.frame}, &of_one_cell},
      {"nothing measured", {&empty.frame}, &usual},
      {"large and small in turn", {&ordinary.frame, &small.frame}, &usual},
  };
  std::printf("%-32s %9s %9s %12s %12s %8s %14s %8s\n", "frame", "points", "cells", "first ms", "device ms", "ratio",
              "latency ms", "ratio");
  double usual_device = 0, usual_latency = 0;
  for (const Case& unusual : cases) {
    const gpu::OwnStream stream;
    Gpu fusion;
    fusion.setStream(stream.get());
    fusion.setParameters(*unusual.parameters);
    gpu::Execution().wait();
    const Clock::time_point begin = Clock::now();
    const std::size_t points = fusion.fusePinned(*unusual.frames[0]).size;
    const double first = since(begin);
    const std::size_t cells = fusion.getStatistics().coarse_cells;
    std::vector<double> device, latency;
    for (int k = 0; k < 64; ++k) {
      const std::size_t turn = static_cast<std::size_t>(k) % unusual.frames.size();
      fusion.stageTimes().enabled = k % 4 > 1;  // which costs latency
      const Clock::time_point start = Clock::now();
      fusion.fusePinned(*unusual.frames[turn]);
      if (turn > 0 || k < 8) continue;
      if (fusion.stageTimes().enabled) {
        device.push_back(deviceTime(fusion));
      } else {
        latency.push_back(since(start));
      }
    }
    if (usual_device == 0) {
      usual_device = median(device);
      usual_latency = median(latency);
    }
    std::printf("%-32s %9zu %9zu %12.3f %12.4f %8.2f %14.3f %8.2f\n", unusual.name, points, cells, first,
                median(device), median(device) / usual_device, median(latency), median(latency) / usual_latency);
    std::fflush(stdout);
  }
}

}  // namespace

int main(int argc, char** argv) try {
  Options options;
  for (int k = 1; k < argc; ++k) {
    const std::string argument = argv[k];
    Size size{};
    if (argument == "--quick") {
      options.quick = true;
    } else if (argument == "--no-cpu") {
      options.cpu = false;
    } else if (argument == "--unusual") {
      options.unusual = true;
    } else if (argument == "--dump" && k + 1 < argc) {
      options.dump = argv[++k];
    } else if (std::sscanf(argument.c_str(), "%dx%dx%d", &size.cameras, &size.width, &size.height) == 3) {
      options.sizes.push_back(size);
    } else {
      std::fprintf(stderr, "fuse_flow_gpu_bench: %s?\n", argument.c_str());
      return 2;
    }
  }
  if (options.unusual) {
    runUnusual();
    return 0;
  }
  if (options.sizes.empty()) {
    for (const int cameras : {1, 2, 4, 8, 16, 32, 64}) options.sizes.push_back({cameras, 640, 480});
    options.sizes.push_back({8, 1280, 720});
    options.sizes.push_back({32, 1024, 1024});
  }
  const Bandwidth bandwidth = measureBandwidth();
  std::printf("copy within the device %.0f GB/s, up %.1f GB/s, down %.1f GB/s\n", bandwidth.device, bandwidth.up,
              bandwidth.down);
  for (const Size& size : options.sizes) run(size, options, bandwidth);
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "fuse_flow_gpu_bench: %s\n", error.what());
  return 1;
}
