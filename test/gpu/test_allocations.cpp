#include "../count_allocations.h"
#include "device_comparison.h"
#include "random_rig.h"

#include <fuse_flow/gpu/runtime/memory.h>

#include <thread>

#if defined(_OPENMP)
#include <omp.h>
#endif

namespace {

using namespace device_comparison;
using random_rig::Random;
using random_rig::RandomFrame;

/** \brief What was asked for: device and pinned memory together, and the host's, where that is counted. */
struct Requests {
  std::size_t device{0};
  long host{0};
};

template <typename Action>
Requests requestsOf(const Action& action) {
  const std::size_t before = fuse_flow::gpu::memoryRequests();
  const long host = count_allocations::allocationsOf(action);
  return {fuse_flow::gpu::memoryRequests() - before, host};
}

/** \brief Frames of which the first misses a camera. */
std::vector<RandomFrame> frames() {
  Random random(62);
  std::vector<RandomFrame> result(3);
  for (RandomFrame& frame : result) do
      frame.draw(random, 5, 60);
    while (frame.rig.cameras.size() < 4);
  result[0].rig.views[1] = {};
  return result;
}

TEST(GpuAllocations, AreCounted) {
  const std::vector<RandomFrame> some = frames();
  Cloud cloud;
  const Requests first = requestsOf([&] {
    Device device;
    device.fuse(some[0].rig, cloud);
  });
  EXPECT_GT(first.device, 10u);
#if defined(FUSE_FLOW_TEST_COUNTS_ALLOCATIONS)
  EXPECT_GT(first.host, 10);
#endif
}

/** \brief Allocations of one frame. On the CPU, Thrust sorts in two temporary arrays for each thread, and allocates them with malloc,
 *  regardless of its allocator; there are no other allocations. */
long allocationsOfThrust(const fuse_flow::FuseFlowParameters& parameters) {
#if defined(_OPENMP)
  const int threads = omp_get_max_threads();
#else
  const int threads = static_cast<int>(std::thread::hardware_concurrency());
#endif
  return parameters.use_spatial_hash ? 2 * std::max(threads, 1) : 0;
}

void expectNoneOnceWarm(const fuse_flow::FuseFlowParameters& parameters) {
  const std::vector<RandomFrame> some = frames();
  Device device;
  device.setParameters(parameters);
  device.setNumberOfThreads(2);
  Cloud cloud;
  for (int k = 0; k < 3; ++k)
    for (const RandomFrame& frame : some) device.fuse(frame.rig, cloud);
  for (const RandomFrame& frame : some) {
    device.fuse(frame.rig, cloud);  // another calibration uploads its rays anew
    const Requests requests = requestsOf([&] { device.fuse(frame.rig, cloud); });
    EXPECT_EQ(requests.device, 0u);
    EXPECT_LE(requests.host, allocationsOfThrust(parameters));
  }
}

void expectNoneInFlightOnceWarm(const fuse_flow::FuseFlowParameters& parameters) {
  const std::vector<RandomFrame> some = frames();
  const RandomFrame& frame = some.front();
  Device device;
  device.setParameters(parameters);
  device.setFramesInFlight(2);
  Cloud cloud;
  const auto turn = [&] {
    device.submit(frame.rig);
    device.submit(frame.rig);
    device.next(cloud);
    device.next(cloud);
  };
  for (int k = 0; k < 5; ++k) turn();
  const Requests requests = requestsOf(turn);
  EXPECT_EQ(requests.device, 0u);
  EXPECT_LE(requests.host, 2 * allocationsOfThrust(parameters));
}

fuse_flow::FuseFlowParameters pointWise() {
  fuse_flow::FuseFlowParameters parameters;
  parameters.use_spatial_hash = false;
  return parameters;
}

TEST(GpuAllocations, ThereAreNoneOnceTheMemoryIsThere) { expectNoneOnceWarm({}); }

TEST(GpuAllocations, ThereAreNoneWithThePublishedParameters) {
  expectNoneOnceWarm(fuse_flow::FuseFlowParameters::published());
}

TEST(GpuAllocations, ThereAreNonePointWise) { expectNoneOnceWarm(pointWise()); }

TEST(GpuAllocations, ThereAreNoneOfFramesInFlight) {
  expectNoneInFlightOnceWarm({});
  expectNoneInFlightOnceWarm(pointWise());
}

}  // namespace
