#pragma once

#include "gpu_in_flight.h"

#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include <unistd.h>

namespace bench {

/** \brief All frames as files that bench/torch_voxel_average.py reads. */
inline void dump(const Frames& frames, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  std::ofstream rig(folder / "rig.txt");
  rig.precision(17);
  for (const fuse_flow::Camera& camera : frames.at(0).cameras) {
    const fuse_flow::Intrinsics& K = camera.intrinsics;
    rig << K.width << ' ' << K.height << ' ' << K.fx << ' ' << K.fy << ' ' << K.cx << ' ' << K.cy;
    for (int row = 0; row < 3; ++row)
      for (int col = 0; col < 4; ++col) rig << ' ' << camera.T_world_camera.matrix()(row, col);
    rig << '\n';
  }
  bool written = rig.flush().good();
  for (std::size_t k = 0; k < Frames::kCount; ++k) {
    std::ofstream images(folder / ("images" + std::to_string(k) + ".bin"), std::ios::binary);
    images.write(frames.bytes(k).data(), static_cast<std::streamsize>(frames.bytes(k).size()));
    written = written && images.flush().good();
  }
  if (!written) throw std::runtime_error("cannot write into " + folder.string());
}

/** \brief What the peer says of itself: milliseconds from host to host, and points of the first frame. */
struct PeerTime {
  double ms{0}, device_ms{0};
  std::size_t points{0};
  std::string name;
};

/** \brief Runs a command with a folder of frames behind it, and finds in its last line "NAME, …: N points, device X ms, host to host
 *  Y ms". */
inline PeerTime timePeer(const std::string& command, const Frames& frames) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("fuse_flow_gpu_bench_" + std::to_string(::getpid()));
  struct Removal {
    const std::filesystem::path& folder;
    ~Removal() {
      std::error_code ignored;
      std::filesystem::remove_all(folder, ignored);
    }
  } const removal{folder};
  dump(frames, folder);
  std::fflush(stdout);
  std::FILE* output = ::popen((command + " '" + folder.string() + "'").c_str(), "r");
  if (!output) throw std::runtime_error("cannot run " + command);
  char line[1024] = "", last[1024] = "";
  while (std::fgets(line, sizeof line, output)) std::strcpy(last, line);
  const int status = ::pclose(output);
  PeerTime result;
  const char* numbers = std::strchr(last, ':');
  if (status != 0 || !numbers ||
      std::sscanf(numbers, ": %zu points, device %lf ms, host to host %lf ms", &result.points, &result.device_ms,
                  &result.ms) != 3)
    throw std::runtime_error(command + " gave no result, but: " + last);
  result.name = std::string(static_cast<const char*>(last), std::strcspn(last, ","));
  return result;
}

/** \brief Ours, the CPU pipeline and the peer on the same frames, one after the other. */
inline void runPeers(const std::vector<Size>& sizes, const std::string& command,
                     const fuse_flow::FuseFlowParameters& parameters, bool quick) {
  struct Row {
    Size size;
    double latency[kRouteCount], in_flight;
    std::size_t points;
    CpuTime cpu;
    PeerTime peer;
  };
  std::vector<Row> rows;
  for (const Size& size : sizes) {
    const Frames frames(size);
    Row row{size, {}, 0, 0, {}, {}};
    {
      const fuse_flow::gpu::OwnStream stream;
      Gpu fusion;
      fusion.setParameters(parameters);
      fusion.setStream(stream.get());
      row.points = fusion.fusePinned(frames.at(0)).size;
      for (std::size_t r = 0; r < kRouteCount; ++r)
        row.latency[r] = latency(fusion, frames, kRoutes[r], quick ? 5 : size.megapixels() > 10 ? 21 : 61);
    }
    std::vector<double> rates;
    for (int round = 0; round < 3; ++round)
      rates.push_back(framesPerSecond(frames, kRoutes[0], kLanes[0], parameters, quick ? 50 : 300));
    row.in_flight = 1e3 / median(rates);
    row.cpu = timeCpu(frames, parameters);
    row.peer = timePeer(command, frames);
    std::fprintf(stderr, "%s: done\n", size.name().c_str());
    rows.push_back(row);
  }
  if (rows.empty()) return;
  std::printf(
      "milliseconds a frame, host to host, medians; points of the first frame\n\n"
      "| cameras | ours, pinned | ours, into a cloud | ours, pageable into a cloud | ours, %zu in flight, pinned | "
      "CPU, %d "
      "cores | %s, pinned | points, ours | points, CPU | points, %s |\n|---|---|---|---|---|---|---|---|---|---|\n",
      kLanes[0], fuse_flow::host::resolveThreads(0), rows[0].peer.name.c_str(), rows[0].peer.name.c_str());
  for (const Row& row : rows)
    std::printf("| %s | %.2f | %.2f | %.2f | %.2f | %.1f | %.2f | %zu | %zu | %zu |\n", row.size.name().c_str(),
                row.latency[0], row.latency[1], row.latency[2], row.in_flight, row.cpu.ms, row.peer.ms, row.points,
                row.cpu.points, row.peer.points);
}

}  // namespace bench
