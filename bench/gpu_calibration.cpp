// A pose update on the GPU over the number of cameras: a frame's images in pinned memory to poses, where its time goes, and the same
// on the CPU.
//   fuse_flow_gpu_calibration_bench [--no-cpu] [--repeats N] [CAMERAS …]
//   fuse_flow_gpu_calibration_bench --beside [CAMERAS …]     the fusion's rate alone and with poses tracked beside it

#include "gpu_frames.h"
#include "median.h"
#include "rig_error.h"
#include "room.h"

#include <fuse_flow/gpu/calibration/extrinsic_estimation.h>
#include <fuse_flow/gpu/calibration/extrinsic_tracking.h>
#include <fuse_flow/point_types.h>

#include <cstdio>
#include <map>
#include <random>
#include <string>

namespace {

using namespace fuse_flow;
using bench::Clock;
using bench::since;
using Poses = std::vector<Eigen::Isometry3d>;
using Gpu = ExtrinsicEstimation<PointFused, device::Thrust>;
using Cpu = ExtrinsicEstimation<PointFused>;
using Tracking = ExtrinsicTracking<PointFused, device::Thrust>;

constexpr int kFrames = 3;  // different frames, one after the other

/** \brief Every camera 20 mm off in a random direction, and turned by a degree about a random axis. */
Poses disturbed(Poses poses) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  const auto direction = [&] { return Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized(); };
  for (Eigen::Isometry3d& T : poses) {
    T.pretranslate(0.02 * direction());
    T.rotate(Eigen::AngleAxisd(0.017453292519943295, direction()));
  }
  return poses;
}

/** \brief Milliseconds by what they were spent on. */
using Parts = std::map<std::string, std::vector<double>>;

/** \brief The device's time of addFrame(), by its stages. */
void addStages(Gpu& estimation, Parts& parts) {
  double upload = 0, views = 0;
  for (const gpu::StageTimes::Stage& stage : estimation.stageTimes().stages())
    (std::string(stage.name) == "upload" ? upload : views) += stage.ms;
  parts["upload"].push_back(upload);
  parts["views"].push_back(views);
}

struct Case {
  const char* name;
  ExtrinsicParameters parameters;
  Poses start;
};

void run(const Case& c, const std::vector<RigFrame>& frames, const Poses& truth, int repeats, bool with_cpu) {
  const gpu::OwnStream stream;
  Gpu estimation;
  estimation.setStream(stream.get());
  estimation.setParameters(c.parameters);
  Parts parts;
  ExtrinsicResult result;
  const auto update = [&](auto& of, int k) {
    of.clear();
    of.addFrame(frames[static_cast<std::size_t>(k % kFrames)]);
    result = of.estimate(c.start);
  };
  for (int k = 0; k < 4; ++k) update(estimation, k);
  std::vector<double> iterations, evaluations, errors;
  for (int k = 0; k < repeats; ++k) {
    estimation.clear();
    const Clock::time_point start = Clock::now();
    estimation.addFrame(frames[static_cast<std::size_t>(k % kFrames)]);
    const double added = since(start);
    result = estimation.estimate(c.start);
    const double total = since(start);
    const gpu::EstimateTimes& spent = estimation.getEstimateTimes();
    parts["addFrame"].push_back(added);
    parts["sampling"].push_back(spent.sampling);
    parts["correspondences"].push_back(spent.correspondences);
    parts["algebra"].push_back(total - added - spent.sampling - spent.correspondences);
    parts["total"].push_back(total);
    iterations.push_back(result.iterations);
    evaluations.push_back(spent.evaluations);
    for (const bench::PoseError& e : bench::rigError(result.T_world_camera, truth)) errors.push_back(e.mm);
  }
  estimation.stageTimes().enabled = true;
  for (int k = 0; k < repeats; ++k) {
    estimation.clear();
    estimation.addFrame(frames[static_cast<std::size_t>(k % kFrames)]);
    addStages(estimation, parts);
  }
  double cpu = 0;
  if (with_cpu) {
    Cpu on_cpu;
    on_cpu.setParameters(c.parameters);
    std::vector<double> times;
    for (int k = 0; k < 4; ++k) {
      const Clock::time_point start = Clock::now();
      update(on_cpu, k);
      if (k > 0) times.push_back(since(start));
    }
    cpu = bench::median(times);
  }
  const auto of = [&](const char* part) { return bench::median(parts[part]); };
  std::printf("| %zu | %s | %.2f | %.2f | %.2f | %.2f | %.2f | %.2f | %.2f | %.0f | %.0f | %.2f | %.1f | %.0f |\n",
              truth.size(), c.name, of("total"), of("addFrame"), of("upload"), of("views"), of("sampling"),
              of("correspondences"), of("algebra"), bench::median(iterations), bench::median(evaluations),
              bench::median(errors), cpu, 1e-6 * static_cast<double>(estimation.getDeviceBytes()));
  std::fflush(stdout);
}

void run(int cameras, int repeats, bool with_cpu) {
  const bench::Room room(cameras, 640, 480);
  gpu::PinnedBuffer<char> pinned[kFrames];
  std::vector<RigFrame> frames;
  for (int k = 0; k < kFrames; ++k) {
    pinned[k].resize(room.bytes());
    frames.push_back(room.render(pinned[k].data(), static_cast<std::uint32_t>(k)));
  }
  Poses truth;
  for (const Camera& camera : frames[0].cameras) truth.push_back(camera.T_world_camera);
  Gpu calibrated;
  calibrated.addFrame(frames[0]);
  const Poses off = disturbed(truth), found = calibrated.estimate(truth).T_world_camera;
  const ExtrinsicParameters tracking = ExtrinsicTracking<PointFused>::defaultParameters();
  run({"20 mm, 1 degree off", {}, off}, frames, truth, repeats, with_cpu);
  run({"tracking, 20 mm, 1 degree off", tracking, off}, frames, truth, repeats, with_cpu);
  run({"tracking, poses of another frame", tracking, found}, frames, truth, repeats, with_cpu);
}

const Clock::time_point kEpoch = Clock::now();  // of the stamps

/** \brief Frames a second from pinned images to pinned points, fused with the tracked poses if they are tracked. \param updates of
 *  poses meanwhile */
double rate(bench::Gpu& fusion, const bench::Frames& frames, Tracking* tracking, std::size_t& updates) {
  constexpr double milliseconds = 300;
  const std::size_t lanes = 8;
  const std::size_t before = tracking ? tracking->poses()->updates : 0;
  std::size_t count = 0;
  const Clock::time_point start = Clock::now();
  for (; since(start) < milliseconds; ++count) {
    RigFrame frame = frames.at(count);
    frame.stamp = static_cast<std::uint64_t>(1e6 + 1e3 * since(kEpoch));  // as of a camera, microseconds
    if (tracking) {
      tracking->push(frame);
      tracking->apply(frame);
    }
    if (fusion.inFlight() == lanes) fusion.nextPinned([](const auto&, std::uint64_t) {});
    fusion.submit(frame);
  }
  while (fusion.inFlight() > 0) fusion.nextPinned([](const auto&, std::uint64_t) {});
  const double result = 1e3 * static_cast<double>(count) / since(start);
  if (tracking) {
    tracking->finish();
    updates += tracking->poses()->updates - before;
  }
  return result;
}

/** \brief In turn, so that both meet the same machine. */
void runBeside(int cameras) {
  const bench::Frames frames({cameras, 640, 480});
  bench::Gpu fusion;
  fusion.setFramesInFlight(8);
  fusion.setCopyAhead(false);  // the points are taken in pinned memory
  Tracking tracking(frames.at(0).cameras, 0.002);
  std::vector<double> alone, with;
  std::size_t updates = 0, none = 0;
  for (int round = 0; round < 8; ++round) {
    const double first = rate(fusion, frames, nullptr, none), second = rate(fusion, frames, &tracking, updates);
    if (round == 0) continue;  // warming up
    alone.push_back(first);
    with.push_back(second);
  }
  std::printf("| %d | %.0f | %.0f | %.0f %% | %.1f | %.0f |\n", cameras, bench::median(alone), bench::median(with),
              100 * bench::median(with) / bench::median(alone), tracking.poses()->milliseconds,
              static_cast<double>(updates) / (8 * 0.3));
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) try {
  bool with_cpu = true, beside = false;
  int repeats = 30;
  std::vector<int> sizes;
  for (int k = 1; k < argc; ++k) {
    const std::string argument = argv[k];
    int cameras = 0;
    if (argument == "--no-cpu") {
      with_cpu = false;
    } else if (argument == "--beside") {
      beside = true;
    } else if (argument == "--repeats" && k + 1 < argc && std::sscanf(argv[k + 1], "%d", &repeats) == 1 &&
               repeats > 0) {
      ++k;
    } else if (std::sscanf(argument.c_str(), "%d", &cameras) == 1 && cameras > 0) {
      sizes.push_back(cameras);
    } else {
      std::fprintf(stderr, "fuse_flow_gpu_calibration_bench: %s?\n", argument.c_str());
      return 2;
    }
  }
  if (beside) {
    if (sizes.empty()) sizes = {1, 2, 4, 6, 8};
    std::printf(
        "Frames a second, eight in flight, pinned images and points.\n"
        "| cameras of 640x480 | fusion alone | with tracking | rate kept | last update, ms | updates a second |\n"
        "|---|---|---|---|---|---|\n");
    for (const int cameras : sizes) runBeside(cameras);
    return 0;
  }
  if (sizes.empty()) sizes = {2, 4, 8, 16};
  std::printf(
      "Milliseconds, medians; upload and views are the device's time within addFrame.\n"
      "| cameras of 640x480 | start | total | addFrame | upload | views | sampling | correspondences | host algebra | "
      "iterations | evaluations | median error mm | CPU | MB on the device |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const int cameras : sizes) run(cameras, repeats, with_cpu);
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "fuse_flow_gpu_calibration_bench: %s\n", error.what());
  return 1;
}
