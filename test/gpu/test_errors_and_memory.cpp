#include "../refusal.h"
#include "../sanitized.h"
#include "../test_length.h"
#include "device_comparison.h"
#include "random_rig.h"

#include <fstream>
#include <iostream>

namespace {

using namespace device_comparison;
using random_rig::Random;
using random_rig::RandomFrame;
using refusal::expectMentions;
using refusal::messageOf;

/** \brief Two pixels, of which one lies far beyond the lattice. */
struct FarPoint {
  std::vector<float> depth{1.0f, 900.0f};
  fuse_flow::RigFrame rig;
  fuse_flow::FuseFlowParameters parameters;

  FarPoint() {
    fuse_flow::Camera camera;
    camera.name = "far";
    camera.intrinsics = {2, 1, 2.0f, 2.0f, 0.0f, 0.0f, {}};
    camera.T_world_camera.translation().z() = 100.0;
    rig.cameras.push_back(camera);
    rig.views.emplace_back();
    rig.views[0].depth32 = {depth.data(), 2, 1};
    parameters.use_measurement_confidence = false;
    parameters.preprocessing.max_range = 1000.0f;
    parameters.max_noise = 0;
    parameters.aggregation.cell_size = parameters.aggregation.min_cell_size = 0.0005f;
  }
};

TEST(GpuErrors, APointBeyondTheLatticeIsNamedAsOnTheHost) {
  const FarPoint far;
  Host host;
  Device device;
  host.setParameters(far.parameters);
  device.setParameters(far.parameters);
  Cloud cloud;
  const std::string expected = messageOf<pcl::PCLException>([&] { host.fuse(far.rig, cloud); });
  const std::string message = messageOf<pcl::PCLException>([&] { device.fuse(far.rig, cloud); });
  expectMentions(message, {"AdaptiveHashFusion", "(450, 0, 1000)", "0.0005 m from the origin"});
  EXPECT_EQ(message.substr(0, message.find(" in ")), expected.substr(0, expected.find(" in ")));
}

TEST(GpuErrors, TheObjectIsUsableAfterwards) {
  FarPoint far;
  Host host;
  Device device;
  Cloud cloud;
  device.setParameters(far.parameters);
  EXPECT_THROW(device.fuse(far.rig, cloud), pcl::PCLException);
  far.depth[1] = 1.1f;
  expectSame(far.rig, far.parameters, host, device);
}

TEST(GpuErrors, ParametersOutOfRangeAreRefusedAsOnTheHost) {
  fuse_flow::FuseFlowParameters parameters;
  parameters.aggregation.cell_size = -1;
  Host host;
  Device device;
  EXPECT_EQ(messageOf<pcl::BadArgumentException>([&] { device.setParameters(parameters); }),
            messageOf<pcl::BadArgumentException>([&] { host.setParameters(parameters); }));
  EXPECT_GT(device.getParameters().aggregation.cell_size, 0);
}

TEST(GpuErrors, FramesThatContradictThemselvesAreRefusedAsOnTheHost) {
  Random random(51);
  RandomFrame frame;
  frame.draw(random, 3);
  frame.rig.views.pop_back();
  Host host;
  Device device;
  Cloud cloud;
  EXPECT_EQ(messageOf<pcl::BadArgumentException>([&] { device.fuse(frame.rig, cloud); }),
            messageOf<pcl::BadArgumentException>([&] { host.fuse(frame.rig, cloud); }));
  EXPECT_THROW(device.fuse({}, cloud), pcl::BadArgumentException);
}

TEST(GpuErrors, ABilateralGridOfTooManyCellsIsRefused) {
  Random random(52);
  RandomFrame frame;
  do frame.draw(random, 1);
  while (frame.rig.views[0].missing() || frame.rig.cameras[0].intrinsics.height < 2);
  fuse_flow::FuseFlowParameters parameters;
  parameters.preprocessing.bilateral = true;
  parameters.preprocessing.bilateral_sigma_r = 1e-9f;
  Device device;
  device.setParameters(parameters);
  Cloud cloud;
  expectMentions(messageOf<pcl::PCLException>([&] { device.fuse(frame.rig, cloud); }), {"bilateral_sigma_r", "2^32"});
}

TEST(GpuErrors, AFrameOfMorePixelsThanCanBeNumberedIsRefused) {
  fuse_flow::gpu::DeviceBuffer<float> row;  // on the device, so that nothing has to be staged
  row.resize(8192);
  fuse_flow::Camera camera;
  camera.name = "huge";
  camera.intrinsics = {8192, 8192, 8000.0f, 8000.0f, 4096.0f, 4096.0f, {}};
  fuse_flow::RigFrame rig;
  rig.cameras.assign(3, camera);
  rig.views.resize(3);
  for (auto& view : rig.views) {
    view.depth32 = {row.data(), 8192, 8192};  // refused before anything is read
  }
  Device device;
  Cloud cloud;
  expectMentions(messageOf<pcl::PCLException>([&] { device.fuse(rig, cloud); }), {"2^27 pixels"});
}

#if FUSE_FLOW_CUDA
/** \brief Takes all memory of the device but less than a mebibyte. */
class DeviceFiller {
 public:
  DeviceFiller() {
    for (std::size_t size = std::size_t{1} << 36; size >= std::size_t{1} << 20; size /= 2) {
      void* block = nullptr;
      while (cudaMalloc(&block, size) == cudaSuccess) blocks_.push_back(block);
      (void)cudaGetLastError();
    }
  }
  ~DeviceFiller() {
    for (void* block : blocks_) (void)cudaFree(block);
  }
  DeviceFiller(const DeviceFiller&) = delete;

 private:
  std::vector<void*> blocks_;
};

TEST(GpuErrors, RunningOutOfTheDevicesMemoryIsSaidAndSurvived) {
  Random random(54);
  RandomFrame frame;
  do frame.draw(random, 6, 600);
  while (frame.rig.cameras.size() < 4);
  Device device;
  {
    const DeviceFiller filler;
    Cloud cloud;
    expectMentions(messageOf<pcl::PCLException>([&] { device.fuse(frame.rig, cloud); }), {"fuse_flow", "memory"});
  }
  Host host;
  expectSame(frame.rig, {}, host, device);
}
#endif

/** \brief Resident memory of this process, bytes; 0 if it is unknown, or under a sanitizer, which keeps freed memory. */
std::size_t hostBytes() {
#if defined(FUSE_FLOW_TEST_SANITIZED)
  return 0;
#else
  std::ifstream file("/proc/self/statm");
  std::size_t total = 0, resident = 0;
  file >> total >> resident;
  return 4096 * resident;
#endif
}

/** \brief Free memory of the device; 0 where the device is the CPU. */
std::size_t freeDeviceBytes() {
  std::size_t free_bytes = 0;
#if FUSE_FLOW_CUDA
  std::size_t total = 0;
  fuse_flow::gpu::check(cudaMemGetInfo(&free_bytes, &total), "cudaMemGetInfo");
#endif
  return free_bytes;
}

/** \brief Five frames, one after the other, ten thousand times on a GPU: memory is allocated only in the first rounds. */
class GpuMemory : public testing::Test {
 protected:
  GpuMemory() : frames_(5) {
    Random random(53);
    for (RandomFrame& frame : frames_) frame.draw(random, 4, 30);
  }

  /** \brief fuse(frame): the next one. */
  template <typename Fuse>
  void expectSteady(const Fuse& fuse) {
    const int count = timesOver(FUSE_FLOW_CUDA ? 10000 : 500, 20);
    for (int k = 0; k < timesOver(50, 10); ++k) fuse(frameOf(k));
    const std::size_t bytes = device_.getDeviceBytes(), free_bytes = freeDeviceBytes();
    for (int k = 0; k < count / 5; ++k) fuse(frameOf(k));
    const std::size_t before = hostBytes();
    for (int k = count / 5; k < count; ++k) fuse(frameOf(k));
    const std::size_t after = hostBytes();
    std::cout << count << " frames: host memory " << before / 1024 << " KiB after a fifth of them, " << after / 1024
              << " KiB after all; free device memory " << free_bytes / 1024 << " KiB before, "
              << freeDeviceBytes() / 1024 << " KiB after\n";
    EXPECT_EQ(device_.getDeviceBytes(), bytes);
    if (!shortTests()) {  // where a sanitizer's own memory grows
      EXPECT_EQ(freeDeviceBytes(), free_bytes);
      EXPECT_LE(after, before + (256u << 10));
    }
  }

  const fuse_flow::RigFrame& frameOf(int k) const { return frames_[static_cast<std::size_t>(k) % frames_.size()].rig; }

  std::vector<RandomFrame> frames_;
  const fuse_flow::gpu::OwnStream stream_;
  Device device_;
  Cloud cloud_;
};

TEST_F(GpuMemory, DoesNotGrowOnceWarm) {
  expectSteady([&](const fuse_flow::RigFrame& frame) { device_.fuse(frame, cloud_); });
  EXPECT_GT(device_.getDeviceBytes(), 0u);
}

// Each frame three times over, so that its launches are captured, and replayed, as graphs.
TEST_F(GpuMemory, DoesNotGrowOnceWarmOnAStreamOfItsOwn) {
  device_.setStream(stream_.get());
  expectSteady([&](const fuse_flow::RigFrame& frame) {
    for (int repeat = 0; repeat < 3; ++repeat) device_.fuse(frame, cloud_);
  });
#if FUSE_FLOW_CUDA
  EXPECT_GT(device_.getGraphReplays(), shortTests() ? 0u : 50u);
#endif
}

TEST_F(GpuMemory, DoesNotGrowOnceWarmWithFramesInFlight) {
  expectSteady([&](const fuse_flow::RigFrame& frame) {
    if (device_.inFlight() == 3) device_.next(cloud_);
    device_.submit(frame);
  });
  while (device_.inFlight() > 0) device_.next(cloud_);
}

}  // namespace
