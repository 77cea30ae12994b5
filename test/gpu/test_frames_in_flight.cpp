#include "../test_length.h"
#include "device_comparison.h"
#include "random_rig.h"

#include <pcl/exceptions.h>

#include <thread>

namespace {

using namespace device_comparison;
using random_rig::Random;
using random_rig::RandomFrame;

/** \brief Frames, and the bytes of their clouds, each fused alone. */
struct Expected {
  std::vector<RandomFrame> frames;
  std::vector<std::vector<Bytes>> bytes;

  /** \brief cameras, and pixels of the longer side of an image, are what there may be at most. */
  Expected(unsigned int seed, std::size_t count, int cameras, int side, std::size_t least_points) : frames(count) {
    Random random(seed);
    Device one;
    Cloud cloud;
    for (RandomFrame& frame : frames) {
      int tries = 0;
      do {
        frame.draw(random, cameras, side);
        one.fuse(frame.rig, cloud);
      } while (cloud.size() < least_points && ++tries < 50);
      EXPECT_GE(cloud.size(), least_points);
      bytes.push_back(bytesOf(cloud));
    }
  }
};

void comeBackInTurnWithTheBytesOfOneAtATime(const Expected& alone, const std::vector<std::size_t>& lanes_tried) {
  const std::vector<RandomFrame>& frames = alone.frames;
  const std::vector<std::vector<Bytes>>& expected = alone.bytes;
  Device several;
  Cloud cloud;
  for (const std::size_t lanes : lanes_tried) {
    several.setFramesInFlight(lanes);
    several.setCopyAhead(lanes != 2);
    for (std::size_t k = 0; warmFirst() && k < frames.size() * lanes; ++k) {
      several.submit(frames[k / lanes].rig);
      several.next(cloud);
    }
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

TEST(GpuFramesInFlight, ComeBackInTurnWithTheBytesOfOneAtATime) {
  comeBackInTurnWithTheBytesOfOneAtATime(Expected(41, 12, 5, 60, 50), {1, 2, 3, 5});
}

TEST(GpuFramesInFlight, LargeOnesComeBackInTurnWithTheBytesOfOneAtATime) {
  comeBackInTurnWithTheBytesOfOneAtATime(Expected(48, 6, 8, 240, 3000), {3, 6});
}

/** Three objects in threads of their own, two frames of each in flight. */
void severalObjectsAtOnceGiveTheBytesOfOne(bool warm, std::size_t rounds) {
  const Expected alone(47, 4, 5, 60, 50);
  const std::vector<RandomFrame>& frames = alone.frames;
  const std::vector<std::vector<Bytes>>& expected = alone.bytes;
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

TEST(GpuFramesInFlight, SeveralObjectsGrowingAtOnceGiveTheBytesOfOne) {
  severalObjectsAtOnceGiveTheBytesOfOne(warmFirst(), static_cast<std::size_t>(timesOver(40, 4)));
}

// fuse() in the caller's threads, on the caller's streams, where launches are replayed as graphs.
TEST(GpuFramesInFlight, SeveralObjectsOnStreamsOfTheirOwnGiveTheBytesOfOne) {
  const Expected alone(49, 4, 5, 120, 500);
  constexpr std::size_t objects = 4;
  std::vector<int> wrong(objects, 0);
  std::vector<std::size_t> replays(objects, 0);
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < objects; ++t)
    threads.emplace_back([&, t] {
      const fuse_flow::gpu::OwnStream stream;
      Device device;
      device.setStream(stream.get());
      Cloud cloud;
      for (int k = 0; k < timesOver(20, 8); ++k) {
        const std::size_t frame = (t + static_cast<std::size_t>(k) / 5) % alone.frames.size();  // several times over
        device.fuse(alone.frames[frame].rig, cloud);
        wrong[t] += bytesOf(cloud) == alone.bytes[frame] ? 0 : 1;
      }
      replays[t] = device.getGraphReplays();
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, std::vector<int>(objects, 0));
#if FUSE_FLOW_CUDA
  for (const std::size_t count : replays) EXPECT_GT(count, 0u);
#endif
}

TEST(GpuFramesInFlight, MayBeTakenWithoutACopy) {
  Random random(42);
  RandomFrame frame;
  frame.draw(random);
  Device device;
  Cloud cloud;
  device.fuse(frame.rig, cloud);
  ASSERT_GT(cloud.size(), 50u);
  device.submit(frame.rig);
  bool visited = false;
  device.nextPinned([&](const fuse_flow::gpu::PointSpan<PointFused>& points, std::uint64_t stamp) {
    visited = true;
    EXPECT_EQ(points.size, cloud.size());
    EXPECT_EQ(stamp, frame.rig.stamp);
    EXPECT_TRUE(bytesOf(points) == bytesOf(cloud));
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

TEST(GpuFramesInFlight, NormalsThatAreNotKnownAreSaidWhateverIsAskedOfTheNextFrame) {
  using PointT = pcl::PointXYZRGBNormal;
  Random random(44);
  RandomFrame frame;
  fuse_flow::FuseFlow<PointT, fuse_flow::device::Thrust> device;
  pcl::PointCloud<PointT> alone, cloud;
  for (int tries = 0; alone.is_dense && tries < 50; ++tries) {
    frame.draw(random);
    device.setComputeNormals(true);
    device.fuse(frame.rig, alone);
  }
  ASSERT_FALSE(alone.is_dense) << "a frame with a normal that is not known";
  for (const bool ahead : {true, false}) {
    device.setCopyAhead(ahead);
    device.setComputeNormals(true);
    device.submit(frame.rig);
    device.setComputeNormals(false);
    device.submit(frame.rig);
    device.next(cloud);
    EXPECT_FALSE(cloud.is_dense);
    device.setComputeNormals(true);
    device.next(cloud);
    EXPECT_TRUE(cloud.is_dense) << "no normals were asked for";
    EXPECT_EQ(cloud.size(), alone.size());
  }
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
