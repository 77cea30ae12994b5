#include "../test_length.h"
#include "device_comparison.h"
#include "random_rig.h"

#if defined(FUSE_FLOW_TEST_HAS_RECORDINGS)
#include "../simulated_recording.h"

#include <fuse_flow/recordings/recording.h>

#include <filesystem>
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
  for (int k = 0; k < timesOver(400, 40); ++k) {
    SCOPED_TRACE(k);
    frame.draw(random, 6, k % 20 == 0 ? 120 : 40);  // now and then large enough to tell the noise
    const int cameras = static_cast<int>(frame.rig.cameras.size());
    expectSame(frame.rig, random_rig::parameters(random, 1.5, cameras), host, device, &tally);
    ASSERT_FALSE(HasFailure());
  }
  EXPECT_GT(tally.points, enough(100000));
  EXPECT_TRUE(tally.good()) << tally;
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomFrames, testing::Values(1, 2, 3, 4, 5, 6, 7, 8));

TEST(GpuSameAsHost, AGivenConfidenceIsThatOfTheHost) {
  random_rig::Random random(31);
  random_rig::RandomFrame frame;
  Host host;
  Device device;
  Tally tally;
  for (int k = 0; k < timesOver(100, 10); ++k) {
    SCOPED_TRACE(k);
    frame.draw(random);
    frame.giveConfidence(random);
    FuseFlowParameters parameters = random_rig::parameters(random, 1.5, static_cast<int>(frame.rig.cameras.size()));
    parameters.confidence.form = fuse_flow::ConfidenceForm::Given;
    expectSame(frame.rig, parameters, host, device, &tally);
    ASSERT_FALSE(HasFailure());
  }
  EXPECT_GT(tally.points, enough(10000));
  EXPECT_TRUE(tally.good()) << tally;
}

TEST(GpuSameAsHost, PixelsThatNoRayReachesMeasureNothingAsOnTheHost) {
  random_rig::Random random(33);
  random_rig::RandomFrame frame;
  Host host;
  Device device;
  Tally tally;
  std::size_t dropped = 0;
  for (int k = 0; k < timesOver(60, 8); ++k) {
    SCOPED_TRACE(k);
    frame.draw(random);
    const FuseFlowParameters parameters =
        random_rig::parameters(random, 1.5, static_cast<int>(frame.rig.cameras.size()));
    for (const float k1 : {0.0f, -2.0f}) {  // no ray ends more than 0.27 focal lengths from the middle
      for (fuse_flow::Camera& camera : frame.rig.cameras) camera.intrinsics.distortion.k1 = k1;
      expectSame(frame.rig, parameters, host, device, &tally);
      ASSERT_FALSE(HasFailure());
      if (k1 == 0) dropped += host.getStatistics().measured_points;
    }
    ASSERT_LE(host.getStatistics().measured_points, dropped);
    dropped -= host.getStatistics().measured_points;
  }
  EXPECT_GT(dropped, 1000u);
  EXPECT_TRUE(tally.good()) << tally;
}

TEST(GpuSameAsHost, AConfidenceThatIsNotGivenIsRefusedAsByTheHost) {
  random_rig::Random random(32);
  random_rig::RandomFrame frame;
  frame.draw(random);
  for (fuse_flow::DepthView& view : frame.rig.views) view.confidence = {};
  FuseFlowParameters parameters;
  parameters.confidence.form = fuse_flow::ConfidenceForm::Given;
  Device device;
  device.setParameters(parameters);
  pcl::PointCloud<fuse_flow::PointFused> cloud;
  EXPECT_THROW(device.fuse(frame.rig, cloud), pcl::BadArgumentException);
}

TEST(GpuSameAsHost, NormalsAreThoseOfTheHost) {
  using PointT = pcl::PointXYZRGBNormal;
  random_rig::Random random(21);
  random_rig::RandomFrame frame;
  fuse_flow::FuseFlow<PointT> host;
  fuse_flow::FuseFlow<PointT, fuse_flow::device::Thrust> device;
  host.setComputeNormals(true);
  device.setComputeNormals(true);
  const auto same = [](const PointT& a, const PointT& b) {
    const auto near = [](std::uint8_t c, std::uint8_t d) { return std::abs(int{c} - int{d}) <= kLevels; };
    const bool unknown = std::isnan(a.normal_x) && std::isnan(b.normal_x);
    return samePosition(a, b) && (unknown || (a.getNormalVector3fMap() - b.getNormalVector3fMap()).norm() < 1e-3f) &&
           near(a.r, b.r) && near(a.g, b.g) && near(a.b, b.b);
  };
  std::size_t points = 0, alone = 0, unknown = 0;
  for (int k = 0; k < timesOver(60, 6); ++k) {
    frame.draw(random);
    pcl::PointCloud<PointT> expected, cloud;
    host.fuse(frame.rig, expected);
    device.fuse(frame.rig, cloud);
    ASSERT_EQ(cloud.size(), expected.size());
    ASSERT_EQ(cloud.is_dense, expected.is_dense);
    unknown += expected.is_dense ? 0 : 1;
    alone += pointsAlone(expected, cloud, same);
    points += expected.size() + cloud.size();
  }
  EXPECT_GT(points, enough(10000));
  EXPECT_LE(alone * 1000, points);
  EXPECT_GT(unknown, 0u);
}

TEST(GpuSameAsHost, TheCamerasOfAPointAreThoseOfTheHost) {
  using PointT = fuse_flow::PointFusedCameras;
  random_rig::Random random(23);
  random_rig::RandomFrame frame;
  fuse_flow::FuseFlow<PointT> host;
  fuse_flow::FuseFlow<PointT, fuse_flow::device::Thrust> device;
  const auto same = [](const PointT& a, const PointT& b) {
    return samePosition(a, b) && a.view_count == b.view_count && a.camera_mask[0] == b.camera_mask[0] &&
           a.camera_mask[1] == b.camera_mask[1];
  };
  std::size_t points = 0, alone = 0, of_many = 0;
  for (int k = 0; k < timesOver(60, 6); ++k) {
    frame.draw(random, 9);
    if (k % 3 == 0) {  // cameras that see the same, else hardly four agree
      frame.rig.cameras.assign(9, fuse_flow::Camera(frame.rig.cameras[0]));
      frame.rig.views.assign(9, fuse_flow::DepthView(frame.rig.views[0]));
    }
    const FuseFlowParameters parameters =
        random_rig::parameters(random, 1.5, static_cast<int>(frame.rig.cameras.size()));
    host.setParameters(parameters);
    device.setParameters(parameters);
    pcl::PointCloud<PointT> expected, cloud;
    host.fuse(frame.rig, expected);
    device.fuse(frame.rig, cloud);
    ASSERT_EQ(cloud.size(), expected.size());
    alone += pointsAlone(expected, cloud, same);
    points += expected.size() + cloud.size();
    for (const PointT& p : expected) of_many += p.view_count > 3 ? 1 : 0;
  }
  EXPECT_GT(points, enough(10000));
  if (!shortTests()) {
    EXPECT_GT(of_many, 100u) << "in few frames there may be none";
  }
  EXPECT_LE(alone * 1000, points);
}

TEST(GpuSameAsHost, TheIntensityIsThatOfTheHost) {
  using PointT = pcl::PointXYZI;
  random_rig::Random random(24);
  random_rig::RandomFrame frame;
  fuse_flow::FuseFlow<PointT> host;
  fuse_flow::FuseFlow<PointT, fuse_flow::device::Thrust> device;
  std::size_t points = 0, alone = 0;
  for (int k = 0; k < timesOver(20, 4); ++k) {
    const bool weight = k % 2 == 1;
    host.setWeightInIntensity(weight);
    device.setWeightInIntensity(weight);
    frame.draw(random);
    pcl::PointCloud<PointT> expected, cloud;
    host.fuse(frame.rig, expected);
    device.fuse(frame.rig, cloud);
    ASSERT_EQ(cloud.size(), expected.size());
    alone += pointsAlone(expected, cloud, [&](const PointT& a, const PointT& b) {
      return samePosition(a, b) && std::fabs(a.intensity - b.intensity) <= (weight ? 1e-4f : kLevels);
    });
    points += expected.size() + cloud.size();
  }
  EXPECT_LE(alone * 1000, points);
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
  EXPECT_EQ(pointsAlone(expected, cloud, samePosition<pcl::PointXYZ>), 0u);
}

#if defined(FUSE_FLOW_TEST_HAS_RECORDINGS)
TEST(GpuSameAsHost, TheDemoRecordingIsFusedAsOnTheHost) {
  Host host;
  Device device;
  const auto count = static_cast<std::size_t>(timesOver(2, 1));
  for (const fuse_flow::io::LoadedFrame& frame : simulated_recording::frames(shortTests() ? 0.25 : 0.5, count)) {
    for (FuseFlowParameters parameters : {FuseFlowParameters(), FuseFlowParameters::published()})
      for (const bool hash : {true, false}) {
        parameters.use_spatial_hash = hash;
        expectSame(frame.rig, parameters, host, device);
      }
  }
}

TEST(GpuSameAsHost, ARealRecordingIsFusedAsOnTheHost) {
  const std::string folder = FUSE_FLOW_TEST_SHARED_DATA "/seven_scenes";
  if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << folder << " is not there";
  fuse_flow::io::RecordingOptions options;
  options.views = "0,60,120,180";
  fuse_flow::io::LoadedFrame frame;
  fuse_flow::io::openRecording({folder}, options)->read(0, frame);
  Host host;
  Device device;
  for (const FuseFlowParameters& parameters : {FuseFlowParameters(), FuseFlowParameters::published()}) {
    Tally tally;
    expectSame(frame.rig, parameters, host, device, &tally);
    EXPECT_GT(tally.points, 300000u);
    EXPECT_TRUE(tally.good()) << tally;
  }
}
#endif

}  // namespace
