#include "device_comparison.h"
#include "random_rig.h"

#if defined(FUSE_FLOW_TEST_HAS_RECORDINGS)
#include "io/demo_scene.h"
#endif

namespace {

using namespace device_comparison;
using fuse_flow::FuseFlowParameters;

class RandomFrames : public testing::TestWithParam<unsigned int> {};

TEST_P(RandomFrames, AreFusedAsOnTheHost) {
  random_rig::Random random(GetParam());
  random_rig::RandomFrame frame;
  Host host;
  Device device;
  Tally tally;
  for (int k = 0; k < 400; ++k) {
    SCOPED_TRACE(k);
    frame.draw(random, 6, k % 20 == 0 ? 120 : 40);  // now and then large enough to tell the noise
    expectSame(frame.rig, random_rig::parameters(random), host, device, &tally);
    ASSERT_FALSE(HasFailure());
  }
  EXPECT_GT(tally.points, 100000u);
  EXPECT_TRUE(tally.good()) << tally.alone << " of " << tally.points << " points are on one device only";
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomFrames, testing::Values(1, 2, 3, 4, 5, 6, 7, 8));

TEST(GpuSameAsHost, NormalsAreThoseOfTheHost) {
  using PointT = pcl::PointXYZRGBNormal;
  random_rig::Random random(21);
  random_rig::RandomFrame frame;
  fuse_flow::FuseFlow<PointT> host;
  fuse_flow::FuseFlow<PointT, fuse_flow::device::Thrust> device;
  host.setComputeNormals(true);
  device.setComputeNormals(true);
  const auto sorted = [](pcl::PointCloud<PointT>& cloud) {
    std::sort(cloud.begin(), cloud.end(), [](const PointT& a, const PointT& b) {
      return std::array<float, 3>{a.x, a.y, a.z} < std::array<float, 3>{b.x, b.y, b.z};
    });
  };
  std::size_t points = 0, different = 0;
  for (int k = 0; k < 60; ++k) {
    frame.draw(random);
    pcl::PointCloud<PointT> expected, cloud;
    host.fuse(frame.rig, expected);
    device.fuse(frame.rig, cloud);
    ASSERT_EQ(cloud.size(), expected.size());
    sorted(expected);
    sorted(cloud);
    for (std::size_t p = 0; p < cloud.size(); ++p) {
      const float off = (cloud[p].getNormalVector3fMap() - expected[p].getNormalVector3fMap()).norm();
      different += off < 1e-3f ? 0 : 1;
    }
    points += cloud.size();
  }
  EXPECT_GT(points, 5000u);
  EXPECT_LE(different * 1000, points);
}

TEST(GpuSameAsHost, PointsWithoutColourHaveThePositionsOfTheHost) {
  random_rig::Random random(22);
  random_rig::RandomFrame frame;
  frame.draw(random);
  pcl::PointCloud<pcl::PointXYZ> expected, cloud;
  fuse_flow::FuseFlow<pcl::PointXYZ>().fuse(frame.rig, expected);
  fuse_flow::FuseFlow<pcl::PointXYZ, fuse_flow::device::Thrust>().fuse(frame.rig, cloud);
  ASSERT_EQ(cloud.size(), expected.size());
  ASSERT_GT(cloud.size(), 50u);
  float sum = 0;
  for (std::size_t k = 0; k < cloud.size(); ++k) sum += cloud[k].x - expected[k].x;
  EXPECT_NEAR(sum, 0, 1e-4f);
}

#if defined(FUSE_FLOW_TEST_HAS_RECORDINGS)
TEST(GpuSameAsHost, TheDemoRecordingIsFusedAsOnTheHost) {
  fuse_flow::io::DemoOptions options;
  options.frames = 2;
  options.width = 320;
  options.height = 240;
  const fuse_flow::io::DemoRecording recording = fuse_flow::io::makeDemoRecording(options);
  Host host;
  Device device;
  for (std::size_t k = 0; k < 2; ++k) {
    fuse_flow::RigFrame frame;
    frame.cameras = recording.cameras;
    frame.views.resize(frame.cameras.size());
    for (std::size_t i = 0; i < frame.views.size(); ++i) {
      frame.views[i].depth16 = recording.depth[k][i].view();
      frame.views[i].depth_scale = recording.depth_scale;
      frame.views[i].color = recording.color[k][i].view();
    }
    for (FuseFlowParameters parameters : {FuseFlowParameters(), FuseFlowParameters::published()})
      for (const bool hash : {true, false}) {
        parameters.use_spatial_hash = hash;
        expectSame(frame, parameters, host, device);
      }
  }
}
#endif

}  // namespace
