// The GPU pipeline over the number of cameras: latency, sustained rate for several numbers of frames in flight, device time of every
// stage beside what its bytes take at the measured copy bandwidth, and the CPU pipeline on the same frames.
//   fuse_flow_gpu_bench [--quick] [--no-cpu] [--estimated-depth] [--confirmation-reach METRES] [CAMERASxWIDTHxHEIGHT …]
// Other modes, also with --quick, --confirmation-reach and sizes:
//   --verify         whether frames in flight, and two objects at once, give the bytes of one frame at a time; status 1 if not
//   --torch COMMAND  ours, the CPU pipeline and bench/torch_voxel_average.py, which COMMAND runs, on the same frames
//   --unusual        frames far from what the pipeline is laid out for, beside an ordinary one
//   --dump FOLDER    the frames of one size as files

#include "gpu_frames.h"
#include "gpu_in_flight.h"
#include "gpu_peers.h"
#include "gpu_stages.h"
#include "gpu_unusual.h"
#include "gpu_verify.h"

#include <cstdio>
#include <cstdlib>

namespace {

using namespace bench;
using fuse_flow::FuseFlowParameters;

struct Options {
  bool quick{false};
  bool cpu{true};
  bool unusual{false};
  bool verify{false};
  std::string torch;
  std::string dump;
  FuseFlowParameters parameters;
  std::vector<Size> sizes;

  std::vector<Size> sizesOr(const std::vector<Size>& usual) const { return sizes.empty() ? usual : sizes; }
};

/** \brief What is measured at one size. */
struct Row {
  Size size;
  std::size_t points{0};
  Stages stages;
  std::array<double, kRouteCount> latency_ms{};
  std::array<Rates, kRouteCount> rates;
  double cpu_ms{0};
  std::size_t device_bytes{0};
};

Row measure(const Size& size, const Options& options) {
  Row row;
  row.size = size;
  const Frames frames(size);
  const int repeats = options.quick ? 5 : size.megapixels() > 10 ? 21 : 61;
  {
    const fuse_flow::gpu::OwnStream stream;
    Gpu fusion;
    fusion.setStream(stream.get());
    fusion.setParameters(options.parameters);
    row.points = fusion.fusePinned(frames.at(0)).size;
    row.stages = measureStages(fusion, frames, repeats);
    for (std::size_t r = 0; r < kRouteCount; ++r) row.latency_ms[r] = latency(fusion, frames, kRoutes[r], repeats);
    row.device_bytes = fusion.getDeviceBytes();
  }
  row.rates = measureRates(frames, options.parameters, options.quick);
  if (options.cpu) row.cpu_ms = timeCpu(frames, options.parameters).ms;
  return row;
}

/** \brief Without overlap, a frame in flight would take as long as alone, and no part of it could be under way while another is. */
void printOverlap(const Row& row) {
  const double upload = row.stages.ms("upload"), device = row.stages.deviceMs(), download = row.stages.ms("download");
  const Rates& rates = row.rates[0];
  const auto print = [&](std::size_t lanes, double rate) {
    const double share = 0.1 * rate;  // percent of a second that so many frames take of a millisecond each
    std::printf(
        "%zu in flight, pinned: rate x latency alone %.2f; of the time upload %.0f %%, device %.0f %%, download %.0f "
        "%%, "
        "together %.0f %%\n",
        lanes, 1e-3 * rate * row.latency_ms[0], share * upload, share * device, share * download,
        share * (upload + device + download));
  };
  print(kLanes[0], rates.atDefault());
  if (rates.best() != 0) print(rates.bestLanes(), rates.atBest());
}

void printDetails(const Row& row, const Bandwidth& bandwidth) {
  std::printf("\n## %s: %.2f Mpixel, %zu points, %.3f ns of device time a pixel\n\n", row.size.name().c_str(),
              row.size.megapixels(), row.points, row.stages.deviceMs() / row.size.megapixels());
  row.stages.print(bandwidth);
  std::printf("\n| frames/s, median (least … most) |");
  for (const std::size_t lanes : kLanes) std::printf(" %zu in flight |", lanes);
  std::printf("\n|---|---|---|---|---|---|\n");
  for (std::size_t r = 0; r < kRouteCount; ++r) {
    std::printf("| %s |", kRoutes[r].name);
    const Rates& rates = row.rates[r];
    for (std::size_t lane = 0; lane < kLanes.size(); ++lane)
      std::printf(" %.0f (%.0f … %.0f) |", rates.rate(lane), rates.least(lane), rates.most(lane));
    std::printf("\n");
  }
  std::printf("\n");
  printOverlap(row);
  std::fflush(stdout);
}

void printTables(const std::vector<Row>& rows) {
  std::printf(
      "\n## All\n\n| cameras | device time | a camera | latency, pinned | latency, cloud | latency, pageable to cloud "
      "| CPU, "
      "%d cores | device memory |\n|---|---|---|---|---|---|---|---|\n",
      fuse_flow::host::resolveThreads(0));
  for (const Row& row : rows)
    std::printf("| %s | %.2f ms | %.0f µs | %.2f ms | %.2f ms | %.2f ms | %.1f ms | %.0f MB |\n",
                row.size.name().c_str(), row.stages.deviceMs(), 1e3 * row.stages.deviceMs() / row.size.cameras,
                row.latency_ms[0], row.latency_ms[1], row.latency_ms[2], row.cpu_ms,
                1e-6 * static_cast<double>(row.device_bytes));
  const std::size_t usual = kLanes[0];
  std::printf(
      "\n| frames/s | pinned, %zu in flight | pinned, best | in flight | clouds, %zu in flight | clouds, best | in "
      "flight | "
      "pageable to clouds, %zu in flight | pageable to clouds, best | in flight "
      "|\n|---|---|---|---|---|---|---|---|---|---|\n",
      usual, usual, usual);
  for (const Row& row : rows) {
    std::printf("| %s |", row.size.name().c_str());
    for (const Rates& rates : row.rates)
      std::printf(" %.0f | %.0f | %zu |", rates.atDefault(), rates.atBest(), rates.bestLanes());
    std::printf("\n");
  }
  const auto camera = [&](int cameras) {
    for (const Row& row : rows)
      if (row.size.cameras == cameras && row.size.width == 640 && row.size.height == 480)
        return row.stages.deviceMs() / cameras;
    return 0.0;
  };
  if (camera(8) > 0 && camera(64) > 0)
    std::printf("\ndevice time of a camera, 64 over 8 cameras: %.2f\n", camera(64) / camera(8));
}

void printMachine(const Bandwidth& bandwidth) {
#if FUSE_FLOW_CUDA
  int device = 0, version = 0;
  cudaDeviceProp properties{};
  fuse_flow::gpu::check(cudaGetDevice(&device), "cudaGetDevice");
  fuse_flow::gpu::check(cudaGetDeviceProperties(&properties, device), "cudaGetDeviceProperties");
  fuse_flow::gpu::check(cudaRuntimeGetVersion(&version), "cudaRuntimeGetVersion");
  std::printf("%s, CUDA %d.%d, ", properties.name, version / 1000, version % 1000 / 10);
#endif
  std::printf("%d cores; copies: within the device %.0f GB/s, up %.1f GB/s, down %.1f GB/s\n",
              fuse_flow::host::resolveThreads(0), bandwidth.device, bandwidth.up, bandwidth.down);
  std::fflush(stdout);
}

void runAll(const Options& options) {
  std::vector<Size> sizes;
  for (const int cameras : {1, 2, 4, 8, 16, 32, 64}) sizes.push_back({cameras, 640, 480});
  sizes.push_back({8, 1280, 720});
  sizes.push_back({32, 1024, 1024});
  const Bandwidth bandwidth = measureBandwidth(options.quick);
  printMachine(bandwidth);
  std::vector<Row> rows;
  for (const Size& size : options.sizesOr(sizes)) {
    rows.push_back(measure(size, options));
    printDetails(rows.back(), bandwidth);
  }
  printTables(rows);
}

/** \brief False: there is an argument that means nothing. */
bool parse(int argc, char** argv, Options& options) {
  for (int k = 1; k < argc; ++k) {
    const std::string argument = argv[k];
    const bool has_value = k + 1 < argc;
    Size size{};
    if (argument == "--quick") {
      options.quick = true;
    } else if (argument == "--no-cpu") {
      options.cpu = false;
    } else if (argument == "--estimated-depth") {
      options.parameters = fuse_flow::FuseFlowParameters::estimatedDepth();
    } else if (argument == "--unusual") {
      options.unusual = true;
    } else if (argument == "--verify") {
      options.verify = true;
    } else if (argument == "--torch" && has_value) {
      options.torch = argv[++k];
    } else if (argument == "--dump" && has_value) {
      options.dump = argv[++k];
    } else if (argument == "--confirmation-reach" && has_value) {
      char* end = nullptr;
      options.parameters.aggregation.confirmation_reach = std::strtof(argv[++k], &end);
      if (*argv[k] == '\0' || *end != '\0') {
        std::fprintf(stderr, "fuse_flow_gpu_bench: --confirmation-reach %s?\n", argv[k]);
        return false;
      }
    } else if (std::sscanf(argument.c_str(), "%dx%dx%d", &size.cameras, &size.width, &size.height) == 3 &&
               size.cameras > 0 && size.width > 0 && size.height > 0) {
      options.sizes.push_back(size);
    } else {
      std::fprintf(stderr, "fuse_flow_gpu_bench: %s?\n", argument.c_str());
      return false;
    }
  }
  if (options.dump.empty() || options.sizes.size() == 1) return true;
  std::fprintf(stderr, "fuse_flow_gpu_bench: --dump takes one size\n");
  return false;
}

}  // namespace

int main(int argc, char** argv) try {
  Options options;
  if (!parse(argc, argv, options)) return 2;
  const std::vector<Size> targets{{8, 640, 480}, {32, 1024, 1024}};
  if (!options.dump.empty()) {
    dump(Frames(options.sizes[0]), options.dump);
  } else if (options.verify) {
    std::size_t different = 0;
    for (const Size& size : options.sizesOr(targets)) different += verify(size, options.parameters, options.quick);
    return different == 0 ? 0 : 1;
  } else if (!options.torch.empty()) {
    runPeers(options.sizesOr(targets), options.torch, options.parameters, options.quick);
  } else if (options.unusual) {
    for (const Size& size : options.sizesOr({{8, 640, 480}})) runUnusual(size, options.parameters, options.quick);
  } else {
    runAll(options);
  }
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "fuse_flow_gpu_bench: %s\n", error.what());
  return 1;
}
