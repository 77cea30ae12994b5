#include "device_comparison.h"
#include "random_rig.h"

#if FUSE_FLOW_CUDA
#include <chrono>
#include <thread>
#endif

namespace {

using namespace device_comparison;
using random_rig::Random;
using random_rig::RandomFrame;

TEST(GpuFramesOnDevice, FramesInFlightAreTakenThereWithTheBytesOfOneAtATime) {
  Random random(63);
  std::vector<RandomFrame> frames(7);
  for (RandomFrame& frame : frames) frame.draw(random, 5, 60);
  Device one, several;
  several.setFramesInFlight(2);
  Cloud expected, downloaded;
  fuse_flow::gpu::DeviceCloud<PointFused> on_device;  // its memory goes round with the lanes'
  for (const bool leave : {true, false}) {
    several.setLeaveOnDevice(leave);
    std::size_t taken = 0;
    const auto take = [&] {
      const fuse_flow::RigFrame& rig = frames[taken++].rig;
      one.fuse(rig, expected);
      several.nextOnDevice(on_device);
      on_device.download(downloaded);
      EXPECT_TRUE(bytesOf(downloaded) == bytesOf(expected));
      EXPECT_EQ(downloaded.header.stamp, rig.stamp);
      EXPECT_EQ(several.getStatistics().fused_points, expected.size());
    };
    for (const RandomFrame& frame : frames) {
      if (several.inFlight() == 2) take();
      several.submit(frame.rig);
    }
    while (several.inFlight() > 0) take();
  }
  EXPECT_THROW(several.nextOnDevice(on_device), pcl::PCLException);
}

TEST(GpuFramesOnDevice, WhatWasLeftThereCanStillBeTakenToTheHost) {
  Random random(64);
  RandomFrame frame;
  Cloud expected, cloud;
  Device device;
  while (expected.empty()) {
    frame.draw(random, 5, 60);
    device.fuse(frame.rig, expected);
  }
  device.setLeaveOnDevice(true);
  device.submit(frame.rig);
  device.submit(frame.rig);
  device.next(cloud);
  EXPECT_TRUE(bytesOf(cloud) == bytesOf(expected));
  device.nextPinned([&](const fuse_flow::gpu::PointSpan<PointFused>& points, std::uint64_t) {
    EXPECT_EQ(points.size, expected.size());
    EXPECT_TRUE(points.points != nullptr);
  });
}

#if FUSE_FLOW_CUDA
TEST(GpuFramesOnDevice, AFrameWaitsForWhatIsOnTheStreamBeforeIt) {
  constexpr int width = 64, height = 48;
  const std::vector<float> depth(width * height, 1.5f);
  fuse_flow::RigFrame rig;
  rig.cameras.emplace_back();
  rig.cameras[0].intrinsics = {width, height, 60.0f, 60.0f, 32.0f, 24.0f, {}};
  rig.views.emplace_back();
  rig.views[0].depth32 = {depth.data(), width, height};
  Device device;
  Cloud expected, cloud;
  device.fuse(rig, expected);
  ASSERT_FALSE(expected.empty());

  fuse_flow::gpu::DeviceBuffer<float> image;
  fuse_flow::gpu::PinnedBuffer<float> pinned;
  image.resize(depth.size());
  pinned.resize(depth.size());
  std::copy(depth.begin(), depth.end(), pinned.data());
  rig.views[0].depth32 = {image.data(), width, height};
  const fuse_flow::gpu::OwnStream producer;
  device.setStream(producer.get());
  device.setFramesInFlight(1);
  rig.views[0].depth32.data = pinned.data();
  device.submit(rig);  // the first allocates, which would wait for the device
  device.next(cloud);
  rig.views[0].depth32.data = image.data();
  fuse_flow::gpu::check(cudaMemset(image.data(), 0, depth.size() * sizeof(float)), "cudaMemset");
  const auto sleep = [](void*) { std::this_thread::sleep_for(std::chrono::milliseconds(200)); };
  fuse_flow::gpu::check(cudaLaunchHostFunc(producer.get(), sleep, nullptr), "cudaLaunchHostFunc");
  fuse_flow::gpu::check(
      cudaMemcpyAsync(image.data(), pinned.data(), depth.size() * sizeof(float), cudaMemcpyDefault, producer.get()),
      "cudaMemcpyAsync");
  device.submit(rig);
  device.next(cloud);
  EXPECT_TRUE(bytesOf(cloud) == bytesOf(expected));
}
#endif

}  // namespace
