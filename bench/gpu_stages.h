#pragma once

#include "gpu_frames.h"

#include <cstdio>
#include <map>

namespace bench {

/** \brief Measured, GB/s: read and written bytes of a large copy within the device; up to and down from it, one way. */
struct Bandwidth {
  double device{0}, up{0}, down{0};
};

inline Bandwidth measureBandwidth(bool quick) {
  Bandwidth result;
  fuse_flow::gpu::Execution run;
  const std::size_t n = std::size_t{1} << (quick ? 24 : 28);
  fuse_flow::gpu::DeviceBuffer<std::uint32_t> a, b;
  fuse_flow::gpu::PinnedBuffer<std::uint32_t> pinned;
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

using Stage = fuse_flow::gpu::StageTimes::Stage;

inline bool overTheBus(const Stage& stage) {
  const std::string name = stage.name;
  return name == "upload" || name == "download";
}

/** \brief The sum of the times of a frame's stages, without the bus, milliseconds. */
inline double deviceTime(const std::vector<Stage>& stages) {
  double sum = 0;
  for (const Stage& stage : stages)
    if (!overTheBus(stage)) sum += stage.ms;
  return sum;
}

/** \brief Times of the stages of several frames. */
class Stages {
 public:
  void add(const std::vector<Stage>& stages) {
    last_ = stages;
    for (const Stage& stage : stages) ms_[stage.name].push_back(stage.ms);
    device_.push_back(deviceTime(stages));
  }

  double ms(const std::string& stage) const {
    const auto found = ms_.find(stage);
    return found == ms_.end() ? 0 : median(found->second);
  }
  /** \brief Of all stages but upload and download, the median of their sums. */
  double deviceMs() const { return median(device_); }

  /** \brief Each stage beside two bounds: its inputs read once and its outputs written once, and all that its passes read and
   *  write, over the measured bandwidth. */
  void print(const Bandwidth& bandwidth) const {
    std::printf("| stage | ms | MB, in and out | bound, ms | share | MB, moved | bound, ms | share |\n");
    std::printf("|---|---|---|---|---|---|---|---|\n");
    double once = 0, moved = 0, bus_bytes = 0;
    for (const Stage& stage : last_) {
      const double time = ms(stage.name);
      if (overTheBus(stage)) {
        const double rate = std::string(stage.name) == "upload" ? bandwidth.up : bandwidth.down;
        const double bytes = stage.bytes / 2;  // which counts them on both sides of the bus
        bus_bytes += bytes;
        std::printf("| %s | %.3f | %.1f | %.3f | %.0f %% | | | |\n", stage.name, time, bytes * 1e-6,
                    bytes / rate * 1e-6, 100 * bytes / rate * 1e-6 / time);
        continue;
      }
      once += stage.bytes;
      moved += stage.moved_bytes;
      const double bound = stage.bytes / bandwidth.device * 1e-6;
      const double bound_of_moved = stage.moved_bytes / bandwidth.device * 1e-6;
      std::printf("| %s | %.3f | %.1f | %.3f | %.0f %% | %.1f | %.3f | %.0f %% |\n", stage.name, time,
                  stage.bytes * 1e-6, bound, 100 * bound / time, stage.moved_bytes * 1e-6, bound_of_moved,
                  100 * bound_of_moved / time);
    }
    const double device = deviceMs();
    const double bound = once / bandwidth.device * 1e-6, bound_of_moved = moved / bandwidth.device * 1e-6;
    std::printf("| **device** | **%.3f** | %.1f | **%.3f** | **%.0f %%** | %.1f | %.3f | %.0f %% |\n", device,
                once * 1e-6, bound, 100 * bound / device, moved * 1e-6, bound_of_moved, 100 * bound_of_moved / device);
    std::printf(
        "\nDevice time is %.2f times the bound of inputs and outputs, %.2f times that of bytes moved; images read and "
        "points "
        "written alone: %.1f MB, %.3f ms.\n",
        device / bound, device / bound_of_moved, bus_bytes * 1e-6, bus_bytes / bandwidth.device * 1e-6);
  }

 private:
  std::map<std::string, std::vector<double>> ms_;
  std::vector<double> device_;
  std::vector<Stage> last_;
};

/** \brief One frame at a time, stage by stage. */
inline Stages measureStages(Gpu& fusion, const Frames& frames, int repeats) {
  for (std::size_t k = 0; k < 2 * Frames::kCount; ++k) fusion.fusePinned(frames.at(k));
  Stages result;
  fusion.stageTimes().enabled = true;
  for (int k = 0; k < repeats; ++k) {
    fusion.fusePinned(frames.at(static_cast<std::size_t>(k)));
    result.add(fusion.stageTimes().stages());
  }
  fusion.stageTimes().enabled = false;
  return result;
}

}  // namespace bench
