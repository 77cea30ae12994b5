// Frame time over the number of cameras, ours and PCL's route in the same run. On the 7-Scenes frames where they are
// present, else on simulated ones.

#include "methods/method.h"
#include "simulation/simulator.h"

#include <fuse_flow/recordings/recording.h>

#include <benchmark/benchmark.h>

#include <filesystem>
#include <map>

namespace {

using namespace fuse_flow;

const char* const kSevenScenes = FUSE_FLOW_SHARED_DATA "/seven_scenes";

/** \brief Eight structured-light cameras around a furnished room, calibrated to 2 mm and 0.1 degrees, at one instant. */
const io::LoadedFrame& simulatedFrame() {
  static const io::LoadedFrame once = [] {
    simulation::SimulationOptions options;
    options.rig = "ring-8";
    options.faults.position_error = 0.002;
    options.faults.rotation_error = 0.1 * 0.017453292519943295;
    io::LoadedFrame frame;
    simulation::Simulator(options).measure(0, frame);
    return frame;
  }();
  return once;
}

/** \brief One instant of n cameras at 640×480, with the memory behind it. */
struct Input {
  io::LoadedFrame loaded;
  RigFrame rig;
};

/** \brief Every 20th frame, or neighbours on the ring, so that cameras overlap alike however many there are. */
const RigFrame& frameOf(std::size_t cameras) {
  static std::map<std::size_t, Input> inputs;
  const auto [entry, fresh] = inputs.try_emplace(cameras);
  Input& input = entry->second;
  if (!fresh) return input.rig;
  if (std::filesystem::is_directory(kSevenScenes)) {
    io::RecordingOptions options;
    for (std::size_t i = 0; i < cameras; ++i) options.views += (i ? "," : "") + std::to_string(i * 20);
    io::openRecording({kSevenScenes}, options)->read(0, input.loaded);
    input.rig = input.loaded.rig;
    return input.rig;
  }
  input.rig = simulatedFrame().rig;
  input.rig.cameras.resize(cameras);
  input.rig.views.resize(cameras);
  return input.rig;
}

void report(benchmark::State& state, const io::Method& method, const FrameStatistics& sums, std::size_t points) {
  const auto mean = [&](double sum) { return benchmark::Counter(sum, benchmark::Counter::kAvgIterations); };
  state.counters["preprocess_ms"] = mean(sums.preprocess_ms);
  state.counters["generate_ms"] = mean(sums.generate_ms);
  state.counters["merge_ms"] = mean(sums.merge_ms);
  state.counters["fuse_ms"] = mean(sums.fuse_ms);
  state.counters["output_ms"] = mean(sums.output_ms);
  state.counters["points"] = static_cast<double>(points);
  state.counters["ns/pixel"] =
      benchmark::Counter(static_cast<double>(method.statistics().measured_points) * 1e-9,
                         benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void runMethod(benchmark::State& state, io::Method& method) {
  const RigFrame& frame = frameOf(static_cast<std::size_t>(state.range(0)));
  io::Method::Cloud cloud;
  method.fuse(frame, cloud);
  FrameStatistics sums;
  for (auto _ : state) {
    method.fuse(frame, cloud);
    state.SetIterationTime(1e-3 * method.statistics().total_ms);
    sums.preprocess_ms += method.statistics().preprocess_ms;
    sums.generate_ms += method.statistics().generate_ms;
    sums.merge_ms += method.statistics().merge_ms;
    sums.fuse_ms += method.statistics().fuse_ms;
    sums.output_ms += method.statistics().output_ms;
  }
  report(state, method, sums, cloud.size());
  state.SetComplexityN(state.range(0));
}

void fuseFlow(benchmark::State& state) {
  io::MethodOptions options;
  options.threads = 2;
  runMethod(state, *io::makeMethod("fuse_flow", options));
}

/** \brief The leaf at which VoxelGrid gives our number of points, to 1 %. */
float matchingLeaf(const RigFrame& frame) {
  io::Method::Cloud cloud;
  io::makeMethod("fuse_flow", {})->fuse(frame, cloud);
  const double wanted = static_cast<double>(cloud.size());
  io::MethodOptions options;
  for (int round = 0; round < 6; ++round) {
    io::makeMethod("voxel_grid", options)->fuse(frame, cloud);
    const double ratio = static_cast<double>(cloud.size()) / wanted;
    if (std::abs(ratio - 1) < 0.01) break;
    options.leaf_size *= static_cast<float>(std::sqrt(ratio));  // points on surfaces: their number goes with 1 / leaf²
  }
  return options.leaf_size;
}

void pclVoxelGrid(benchmark::State& state) {
  io::MethodOptions options;
  options.threads = 2;
  options.leaf_size = matchingLeaf(frameOf(static_cast<std::size_t>(state.range(0))));
  runMethod(state, *io::makeMethod("voxel_grid", options));
  state.counters["leaf_mm"] = 1e3 * static_cast<double>(options.leaf_size);
}

/** \brief Times are the methods' own, which leave out what the tools check and convert for the peers. With a line through the
 *  origin, fitted to the times over the number of cameras. */
void overCameras(benchmark::internal::Benchmark* benchmark) {
  for (const int cameras : {1, 2, 4, 6, 8}) benchmark->Arg(cameras);
  benchmark->Unit(benchmark::kMillisecond)->UseManualTime()->Complexity(benchmark::oN);
}

BENCHMARK(fuseFlow)->Apply(overCameras);
BENCHMARK(pclVoxelGrid)->Apply(overCameras);

}  // namespace

BENCHMARK_MAIN();
