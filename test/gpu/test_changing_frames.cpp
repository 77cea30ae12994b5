// What changes from one frame to the next, and frames of unusual size.

#include "../test_length.h"
#include "device_comparison.h"
#include "random_rig.h"

namespace {

using namespace device_comparison;
using fuse_flow::FuseFlowParameters;
using random_rig::Random;
using random_rig::RandomFrame;

/** \brief A camera at the origin that sees one depth everywhere. */
struct Wall {
  fuse_flow::RigFrame rig;
  std::vector<float> depth;

  Wall(int cameras, int width, int height, float z) : depth(static_cast<std::size_t>(width * height), z) {
    for (int i = 0; i < cameras; ++i) {
      fuse_flow::Camera camera;
      camera.name = "wall camera " + std::to_string(i);
      camera.intrinsics = {width,
                           height,
                           static_cast<float>(width),
                           static_cast<float>(width),
                           0.5f * static_cast<float>(width),
                           0.5f * static_cast<float>(height),
                           {}};
      camera.T_world_camera.translation().x() = 0.01 * i;
      rig.cameras.push_back(camera);
      rig.views.emplace_back();
      rig.views.back().depth32 = {depth.data(), width, height};
    }
  }
};

TEST(GpuChangingFrames, TheSameObjectFusesLargeAndSmallFramesInTurn) {
  Random random(31);
  RandomFrame large, small;
  large.draw(random, 6, 90);
  small.draw(random, 2, 12);
  Host host;
  Device device;
  for (int k = 0; k < 4; ++k) {
    expectSame(large.rig, {}, host, device);
    expectSame(small.rig, {}, host, device);
  }
}

// With setStream(), the launches of similar frames are replayed as a graph. Every change must still take effect.
TEST(GpuChangingFrames, RepeatedFramesOnAStreamAreFusedAsTheyAre) {
  Random random(33);
  RandomFrame frame;
  const fuse_flow::gpu::OwnStream stream;
  Host host;
  Device device;
  device.setStream(stream.get());
  Tally tally;
  for (int k = 0; k < timesOver(25, 3); ++k) {
    frame.draw(random, 4, 60);
    FuseFlowParameters parameters = random_rig::parameters(random, 1.5, static_cast<int>(frame.rig.cameras.size()));
    for (int repeat = 0; repeat < 6; ++repeat) {
      if (repeat == 3) parameters.confidence.threshold *= 0.5f;  // same images, same memory, another parameter
      expectSame(frame.rig, parameters, host, device, &tally);
    }
    for (fuse_flow::DepthView& view : frame.rig.views) view.color = {};  // other images of the same size
    expectSame(frame.rig, parameters, host, device, &tally);
    const fuse_flow::DepthView missing = std::exchange(frame.rig.views[0], {});
    expectSame(frame.rig, parameters, host, device, &tally);
    frame.rig.views[0] = missing;
    expectSame(frame.rig, parameters, host, device, &tally);
  }
  EXPECT_TRUE(tally.good()) << tally;
#if FUSE_FLOW_CUDA
  EXPECT_GT(device.getGraphReplays(), shortTests() ? 0u : 25u);
#endif
}

TEST(GpuChangingFrames, EveryRunGivesTheSameBytes) {
  Random random(32);
  RandomFrame frame;
  Device device;
  for (int k = 0; k < timesOver(10, 2); ++k) {
    frame.draw(random, 6, 80);
    device.setParameters(random_rig::parameters(random));
    Cloud cloud;
    device.fuse(frame.rig, cloud);
    const std::vector<Bytes> expected = bytesOf(cloud);
    for (int run = 0; run < 8; ++run) {
      Device other;  // with memory of its own, at other addresses
      other.setParameters(device.getParameters());
      (run % 2 ? device : other).fuse(frame.rig, cloud);
      ASSERT_TRUE(bytesOf(cloud) == expected) << "frame " << k << ", run " << run;
    }
  }
}

TEST(GpuChangingFrames, CamerasComeAndGo) {
  Wall wall(5, 24, 18, 1.0f);
  const std::vector<fuse_flow::DepthView> views = wall.rig.views;
  Host host;
  Device device;
  for (unsigned int present = 0; present < 32; ++present) {
    for (std::size_t i = 0; i < 5; ++i) wall.rig.views[i] = present >> i & 1u ? views[i] : fuse_flow::DepthView();
    expectSame(wall.rig, {}, host, device);
  }
}

TEST(GpuChangingFrames, AFrameWithoutAnyMeasurementGivesAnEmptyCloud) {
  Wall wall(3, 20, 10, 0.0f);
  Device device;
  Cloud cloud;
  for (const bool hash : {true, false}) {
    FuseFlowParameters parameters;
    parameters.use_spatial_hash = hash;
    device.setParameters(parameters);
    device.fuse(wall.rig, cloud);
    EXPECT_TRUE(cloud.empty());
    EXPECT_EQ(device.getStatistics().measured_points, 0u);
  }
}

TEST(GpuChangingFrames, AFrameWithoutAnyViewGivesAnEmptyCloudAfterAFullOne) {
  Wall wall(3, 20, 10, 1.0f);
  Device device;
  Cloud cloud;
  device.fuse(wall.rig, cloud);
  EXPECT_FALSE(cloud.empty());
  wall.rig.views.assign(3, {});
  device.fuse(wall.rig, cloud);
  EXPECT_TRUE(cloud.empty());
  EXPECT_EQ(device.getStatistics().missing_cameras, (std::vector<std::size_t>{0, 1, 2}));
}

TEST(GpuChangingFrames, OnePixelIsAFrame) { expectSame(Wall(1, 1, 1, 1.0f).rig); }

TEST(GpuChangingFrames, WidthsAroundTheSizeOfAWarp) {
  for (const int width : {7, 8, 9, 31, 32, 33, 63, 64, 65}) {
    SCOPED_TRACE(width);
    expectSame(Wall(2, width, 5, 0.8f).rig);
  }
}

TEST(GpuChangingFrames, OneCameraAndSixtyFour) {
  expectSame(Wall(1, 40, 30, 1.0f).rig);
  Random random(33);
  RandomFrame frame;
  do frame.draw(random, 64, 24);
  while (frame.rig.cameras.size() < 60);
  expectSame(frame.rig);
  expectSame(Wall(64, 20, 15, 1.0f).rig);
}

TEST(GpuChangingFrames, RowsMayBePadded) {
  Wall wall(2, 30, 20, 1.0f);
  std::vector<float> padded(37 * 20, 0.7f);  // would be measurements
  for (int v = 0; v < 20; ++v) std::fill_n(padded.begin() + 37 * v, 30, 1.0f);
  for (auto& view : wall.rig.views) view.depth32 = {padded.data(), 30, 20, 37 * sizeof(float)};
  expectSame(wall.rig);
}

TEST(GpuChangingFrames, ScenesOfTenCentimetresAndOfAKilometre) {
  for (const double scale : {0.1, 0.3, 30.0, 1000.0}) {
    Random random(34);
    RandomFrame frame;
    Host host;
    Device device;
    Tally tally;
    for (int k = 0; k < timesOver(40, 4); ++k) {
      SCOPED_TRACE(scale);
      frame.draw(random, 4, 40, scale);
      FuseFlowParameters parameters = random_rig::parameters(random, scale, static_cast<int>(frame.rig.cameras.size()));
      fuse_flow::AggregationParameters& a = parameters.aggregation;
      for (float* length :
           {&a.cell_size, &a.min_cell_size, &a.confirmation_reach, &parameters.preprocessing.bilateral_sigma_r})
        *length = std::min(*length, 10.0f);  // larger ones are refused
      a.min_cell_size = std::min(a.min_cell_size, a.cell_size);
      parameters.preprocessing.min_range = static_cast<float>(0.3 * scale);
      parameters.preprocessing.max_range = static_cast<float>(3 * scale);
      if (scale > 10) {  // where a depth camera's noise is metres: nothing would be left
        parameters.confidence.threshold = parameters.aggregation.min_weight = 0;
        parameters.half_weight_noise = parameters.max_noise = 0;
      }
      expectSame(frame.rig, parameters, host, device, &tally);
      ASSERT_FALSE(HasFailure());
    }
    EXPECT_GT(tally.points, enough(5000)) << scale;
    EXPECT_TRUE(tally.good()) << tally;
  }
}

/** \brief The table starts small: a frame whose every pixel has a coarse cell of its own makes it grow. */
TEST(GpuChangingFrames, AFrameOfManyMoreCellsThanTheTableHasIsFusedAsOnTheHost) {
  Wall wall(1, 300, 250, 8.0f);
  for (std::size_t k = 0; k < wall.depth.size(); ++k) wall.depth[k] = 5.0f + 0.01f * static_cast<float>(k * 7919 % 997);
  FuseFlowParameters parameters;
  parameters.use_measurement_confidence = false;  // of more noise than max_noise, all of it
  parameters.aggregation.cell_size = 0.004f;
  parameters.aggregation.min_cell_size = 0.004f;
  Host host;
  Device device;
  expectSame(wall.rig, parameters, host, device);
  EXPECT_GT(host.getStatistics().coarse_cells, 70000u);
  expectSame(wall.rig, parameters, host, device);
  parameters.aggregation.cell_size = 0.064f;
  expectSame(wall.rig, parameters, host, device);
}

}  // namespace
