#include "device_comparison.h"
#include "random_rig.h"

#include <pcl/exceptions.h>

#include <thread>

namespace {

using namespace device_comparison;
using random_rig::Random;
using random_rig::RandomFrame;

TEST(GpuFramesInFlight, ComeBackInTurnWithTheBytesOfOneAtATime) {
  Random random(41);
  std::vector<RandomFrame> frames(12);
  for (RandomFrame& frame : frames) frame.draw(random, 5, 60);
  Device one, several;
  std::vector<std::vector<Bytes>> expected;
  Cloud cloud;
  for (const RandomFrame& frame : frames) {
    one.fuse(frame.rig, cloud);
    expected.push_back(bytesOf(cloud));
  }
  for (const std::size_t lanes : {1u, 2u, 3u, 5u}) {
    several.setFramesInFlight(lanes);
    several.setCopyAhead(lanes != 2);
    std::size_t next = 0;
    const auto take = [&] {
      several.next(cloud);
      EXPECT_TRUE(bytesOf(cloud) == expected[next]) << "frame " << next;
      EXPECT_EQ(cloud.header.stamp, frames[next].rig.stamp);
      EXPECT_EQ(several.getStatistics().fused_points, cloud.size());
      ++next;
    };
    for (const RandomFrame& frame : frames) {
      if (several.inFlight() == lanes) take();
      several.submit(frame.rig);
    }
    while (several.inFlight() > 0) take();
    EXPECT_EQ(next, frames.size());
  }
}

/** Three objects in threads of their own, two frames of each in flight. */
void severalObjectsAtOnceGiveTheBytesOfOne(bool warm, std::size_t rounds) {
  Random random(47);
  std::vector<RandomFrame> frames(4);
  std::vector<std::vector<Bytes>> expected;
  Device one;
  Cloud cloud;
  for (RandomFrame& frame : frames) {
    frame.draw(random, 5, 60);
    one.fuse(frame.rig, cloud);
    expected.push_back(bytesOf(cloud));
  }
  std::vector<int> wrong(3, 0);
  std::vector<Device> devices(wrong.size());
  const auto run = [&](std::size_t t, std::size_t times) {
    Cloud result;
    for (std::size_t k = 0; k < times; ++k) {
      devices[t].submit(frames[k % 4].rig);
      devices[t].submit(frames[(k + t) % 4].rig);
      devices[t].next(result);
      wrong[t] += bytesOf(result) == expected[k % 4] ? 0 : 1;
      devices[t].next(result);
      wrong[t] += bytesOf(result) == expected[(k + t) % 4] ? 0 : 1;
    }
  };
  if (warm)
    for (std::size_t t = 0; t < devices.size(); ++t) run(t, frames.size());
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < devices.size(); ++t) threads.emplace_back(run, t, rounds);
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, std::vector<int>(3, 0));
}

TEST(GpuFramesInFlight, SeveralObjectsAtOnceGiveTheBytesOfOne) { severalObjectsAtOnceGiveTheBytesOfOne(true, 4); }

// Apart from the one before because compute-sanitizer's racecheck hangs in it: it needs the driver's lock to empty its records,
// and a thread that frees memory holds that lock until all kernels, which wait for room in the records, have ended.
TEST(GpuFramesInFlight, SeveralObjectsGrowingAtOnceGiveTheBytesOfOne) {
  severalObjectsAtOnceGiveTheBytesOfOne(false, 40);
}

TEST(GpuFramesInFlight, MayBeTakenWithoutACopy) {
  Random random(42);
  RandomFrame frame;
  frame.draw(random);
  Device device;
  Cloud cloud;
  device.fuse(frame.rig, cloud);
  device.submit(frame.rig);
  bool visited = false;
  device.nextPinned([&](const fuse_flow::gpu::PointSpan<PointFused>& points, std::uint64_t stamp) {
    visited = true;
    EXPECT_EQ(points.size, cloud.size());
    EXPECT_EQ(stamp, frame.rig.stamp);
    EXPECT_TRUE(std::equal(points.begin(), points.end(), cloud.begin(),
                           [](const PointFused& a, const PointFused& b) { return a.x == b.x && a.y == b.y; }));
  });
  EXPECT_TRUE(visited);
}

TEST(GpuFramesInFlight, EachHasTheParametersOfItsSubmission) {
  Random random(43);
  RandomFrame frame;
  frame.draw(random, 3, 60);
  fuse_flow::FuseFlowParameters coarse, fine;
  coarse.aggregation.min_cell_size = coarse.aggregation.cell_size;
  Device device;
  device.setParameters(fine);
  device.submit(frame.rig);
  device.setParameters(coarse);
  device.submit(frame.rig);
  Cloud first, second;
  device.next(first);
  device.next(second);
  EXPECT_GT(first.size(), second.size());
}

TEST(GpuFramesInFlight, NoMoreThanAllowed) {
  Random random(44);
  RandomFrame frame;
  frame.draw(random);
  Device device;
  device.setFramesInFlight(2);
  device.submit(frame.rig);
  device.submit(frame.rig);
  EXPECT_EQ(device.inFlight(), 2u);
  EXPECT_THROW(device.submit(frame.rig), pcl::PCLException);
  EXPECT_THROW(device.setFramesInFlight(3), pcl::PCLException);
  Cloud cloud;
  device.next(cloud);
  device.next(cloud);
  EXPECT_THROW(device.next(cloud), pcl::PCLException);
  EXPECT_THROW(device.setFramesInFlight(0), pcl::BadArgumentException);
  EXPECT_THROW(device.setFramesInFlight(17), pcl::BadArgumentException);
  device.setFramesInFlight(3);
}

TEST(GpuFramesInFlight, AFrameThatFailsFailsWhereItIsTakenAndTheNextOneDoesNot) {
  Random random(45);
  RandomFrame good, bad;
  good.draw(random);
  bad.draw(random);
  bad.rig.cameras[0].intrinsics.fx = 0;
  Device device;
  device.submit(bad.rig);
  device.submit(good.rig);
  Cloud cloud;
  EXPECT_THROW(device.next(cloud), pcl::BadArgumentException);
  EXPECT_NO_THROW(device.next(cloud));
  EXPECT_EQ(cloud.header.stamp, good.rig.stamp);
}

TEST(GpuFramesInFlight, AnObjectMayGoWhileTheyAre) {
  Random random(46);
  RandomFrame frame;
  frame.draw(random);
  Device device;
  device.submit(frame.rig);
}

}  // namespace
