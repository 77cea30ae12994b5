// Every filter on the device beside itself on the host.

#include "../test_length.h"
#include "device_comparison.h"
#include "furnished_rig.h"
#include "random_rig.h"

#include <fuse_flow/gpu/filters/adaptive_hash_fusion.h>
#include <fuse_flow/gpu/filters/confidence_estimation.h>
#include <fuse_flow/gpu/filters/depth_backprojection.h>
#include <fuse_flow/gpu/filters/multi_view_consistency.h>

#include <pcl/exceptions.h>

namespace {

using namespace fuse_flow;
using device_comparison::Cloud;
using random_rig::Random;
using random_rig::RandomFrame;

/** \brief An organised cloud of each camera that measured, world frame, and which camera each is of. */
struct Clouds {
  std::vector<Cloud::Ptr> of_camera;
  Cloud::Ptr all = std::make_shared<Cloud>();
  std::vector<std::uint32_t> cameras;

  Clouds(const RigFrame& frame, Random& random) {
    DepthBackprojection<PointFused> backprojection;
    for (std::uint32_t i = 0; i < frame.cameras.size(); ++i) {
      of_camera.push_back(std::make_shared<Cloud>());
      if (frame.views[i].missing()) continue;
      backprojection.setCamera(frame.cameras[i]);
      backprojection.setView(frame.views[i]);
      backprojection.filter(*of_camera[i]);
      for (PointFused& point : *of_camera[i]) point.confidence = random.uniform(0.0f, 1.0f);
      *all += *of_camera[i];
      cameras.resize(all->size(), i);
    }
  }
};

void expectSameIndices(const pcl::IndicesConstPtr& host, const pcl::IndicesConstPtr& device) {
  EXPECT_EQ(*device, *host);
}

void expectSameBytes(const Cloud& host, const Cloud& device) {
  EXPECT_TRUE(device_comparison::bytesOf(device) == device_comparison::bytesOf(host));
  EXPECT_EQ(device.width, host.width);
  EXPECT_EQ(device.height, host.height);
  EXPECT_EQ(device.is_dense, host.is_dense);
}

TEST(GpuFilters, ConfidenceEstimationGivesTheHostsConfidenceAndIndices) {
  Random random(61);
  RandomFrame frame;
  for (int k = 0; k < timesOver(40, 12); ++k) {
    frame.draw(random, 1);
    const Clouds clouds(frame.rig, random);
    if (clouds.all->empty() || frame.rig.cameras[0].intrinsics.height < 2) continue;  // a row is not organised
    ConfidenceEstimation<PointFused> host(true);
    ConfidenceEstimation<PointFused, device::Thrust> device(true);
    ConfidenceParameters parameters;
    parameters.form = k % 2 ? ConfidenceForm::Published : ConfidenceForm::SlopeCompensated;
    Cloud expected, cloud;
    for (ConfidenceEstimation<PointFused>* filter : {&host, static_cast<ConfidenceEstimation<PointFused>*>(&device)}) {
      filter->setParameters(parameters);
      filter->setFocalLength(frame.rig.cameras[0].intrinsics.fx);
      filter->setInputCloud(clouds.of_camera[0]);
      filter->setNegative(k % 3 == 0);
      filter->setKeepOrganized(k % 5 == 0);
      filter->filter(filter == &host ? expected : cloud);
    }
    EXPECT_TRUE(device.getConfidence() == host.getConfidence());
    expectSameIndices(host.getRemovedIndices(), device.getRemovedIndices());
    expectSameBytes(expected, cloud);
  }
}

TEST(GpuFilters, DepthBackprojectionGivesTheHostsPoints) {
  Random random(62);
  RandomFrame frame;
  for (int k = 0; k < timesOver(60, 12); ++k) {
    frame.draw(random, 1);
    if (frame.rig.views[0].missing()) continue;
    PreprocessingParameters parameters;
    if (k % 2) parameters.fill_neighbours = 4;
    DepthBackprojection<PointFused> host(true);
    DepthBackprojection<PointFused, device::Thrust> device(true);
    Cloud expected, cloud;
    for (DepthBackprojection<PointFused>* filter : {&host, static_cast<DepthBackprojection<PointFused>*>(&device)}) {
      filter->setCamera(frame.rig.cameras[0]);
      filter->setView(frame.rig.views[0]);
      filter->setParameters(parameters);
      filter->setUserFilterValue(-1);
      filter->filter(filter == &host ? expected : cloud);
    }
    expectSameIndices(host.getRemovedIndices(), device.getRemovedIndices());
    expectSameBytes(expected, cloud);
  }
}

TEST(GpuFilters, DepthBackprojectionTakesMultipathInterferenceAwayAsTheHost) {
  // Images of many tiles, near and far from each other, with edges and holes.
  Random random(67);
  furnished_rig::Options options;
  options.cameras = 2;
  options.width = 300;
  options.height = 220;
  options.distortion = true;
  const furnished_rig::FurnishedRig furnished(random, options);
  for (std::size_t i = 0; i < 2; ++i) {
    Camera camera = furnished.rig.cameras[i];
    std::vector<Cloud> clouds(3);
    DepthBackprojection<PointFused> host;
    DepthBackprojection<PointFused, device::Thrust> device;
    for (DepthBackprojection<PointFused>* filter : {&host, static_cast<DepthBackprojection<PointFused>*>(&device)}) {
      filter->setCamera(camera);
      filter->setView(furnished.rig.views[i]);
      filter->filter(clouds[filter == &host ? 0 : 1]);
    }
    expectSameBytes(clouds[0], clouds[1]);
    camera.multipath = {};
    host.setCamera(camera);
    host.filter(clouds[2]);
    std::size_t moved = 0;
    for (std::size_t k = 0; k < clouds[0].size(); ++k)
      moved += (clouds[0][k].getVector3fMap() - clouds[2][k].getVector3fMap()).norm() > 0.001f ? 1 : 0;
    EXPECT_GT(moved, clouds[0].size() / 5) << "there is indirect light";
  }
}

TEST(GpuFilters, MultiViewConsistencyGivesTheHostsConsistency) {
  Random random(63);
  RandomFrame frame;
  for (int k = 0; k < timesOver(40, 12); ++k) {
    frame.draw(random);
    const Clouds clouds(frame.rig, random);
    const int source = k % 2 ? -1 : random.below(static_cast<int>(frame.rig.cameras.size()));
    const ConsistencyParameters parameters = random_rig::parameters(random).consistency;
    const Cloud::Ptr input = source < 0 ? clouds.all : clouds.of_camera[static_cast<std::size_t>(source)];
    if (input->empty()) continue;
    MultiViewConsistency<PointFused> host(true);
    MultiViewConsistency<PointFused, device::Thrust> device(true);
    Cloud expected, cloud;
    for (MultiViewConsistency<PointFused>* filter : {&host, static_cast<MultiViewConsistency<PointFused>*>(&device)}) {
      filter->setFrame(frame.rig, source);
      filter->setParameters(parameters);
      filter->setInputCloud(input);
      filter->setNegative(k % 3 == 0);
      filter->filter(filter == &host ? expected : cloud);
    }
    EXPECT_EQ(device.getViewCounts(), host.getViewCounts());
    ASSERT_EQ(device.getConsistency().size(), host.getConsistency().size());
    for (std::size_t p = 0; p < host.getConsistency().size(); ++p)
      ASSERT_NEAR(device.getConsistency()[p], host.getConsistency()[p], 1e-5f);
    expectSameIndices(host.getRemovedIndices(), device.getRemovedIndices());
    ASSERT_EQ(cloud.size(), expected.size());
    for (std::size_t p = 0; p < cloud.size(); ++p) {
      EXPECT_EQ(std::memcmp(&cloud[p].x, &expected[p].x, 12), 0) << p;
      EXPECT_NEAR(cloud[p].confidence, expected[p].confidence, 1e-5f) << p;
    }
  }
}

TEST(GpuFilters, AdaptiveHashFusionGivesTheHostsPoints) {
  Random random(64);
  RandomFrame frame;
  device_comparison::Tally tally;
  std::size_t removed = 0, removed_alone = 0;
  for (int k = 0; k < timesOver(80, 12); ++k) {
    frame.draw(random);
    const Clouds clouds(frame.rig, random);
    if (clouds.all->empty()) continue;
    const FuseFlowParameters parameters = random_rig::parameters(random);
    AdaptiveHashFusion<PointFused> host(true);
    AdaptiveHashFusion<PointFused, device::Thrust> device(true);
    Cloud expected, cloud;
    for (AdaptiveHashFusion<PointFused>* filter : {&host, static_cast<AdaptiveHashFusion<PointFused>*>(&device)}) {
      filter->setParameters(parameters.aggregation);
      filter->setInputCloud(clouds.all);
      if (k % 3) filter->setCameraIndices(clouds.cameras);
      if (k % 3 == 2) filter->setFrame(frame.rig, parameters.consistency);
      filter->filter(filter == &host ? expected : cloud);
    }
    tally.add(expected, cloud, parameters.aggregation.cell_size);
    removed += host.getRemovedIndices()->size() + device.getRemovedIndices()->size();
    removed_alone += device_comparison::indicesAlone(*host.getRemovedIndices(), *device.getRemovedIndices());
  }
  EXPECT_GT(removed, enough(20000));
  EXPECT_LE(removed_alone * 10000, removed) << removed_alone << " of " << removed;
  EXPECT_GT(tally.points, enough(5000));
  EXPECT_TRUE(tally.good()) << tally;
}

TEST(GpuFilters, AnEmptyCloudGivesAnEmptyCloud) {
  AdaptiveHashFusion<PointFused, device::Thrust> fusion;
  fusion.setInputCloud(std::make_shared<Cloud>());
  Cloud cloud;
  fusion.filter(cloud);
  EXPECT_TRUE(cloud.empty());
}

TEST(GpuFilters, AFilterMayBeUsedAgainWithAnotherCloud) {
  Random random(65);
  RandomFrame frame;
  AdaptiveHashFusion<PointFused> host;
  AdaptiveHashFusion<PointFused, device::Thrust> device;
  for (int k = 0; k < 6; ++k) {
    frame.draw(random, 3, k % 2 ? 60 : 10);
    const Clouds clouds(frame.rig, random);
    Cloud expected, cloud;
    host.setInputCloud(clouds.all);
    device.setInputCloud(clouds.all);
    host.filter(expected);
    device.filter(cloud);
    device_comparison::Tally tally;
    tally.add(expected, cloud, AggregationParameters().cell_size);
    EXPECT_TRUE(tally.good()) << tally;
  }
}

// PCL's filter on the host, our own kernels on the device: bit by bit, holes and images of one row among them.
TEST(GpuFilters, TheBilateralFilterIsPcls) {
  Random random(66);
  RandomFrame frame;
  std::size_t changed = 0;
  for (int k = 0; k < timesOver(60, 12); ++k) {
    frame.draw(random, 1, k % 10 == 9 ? 2 : 70);
    if (frame.rig.views[0].missing()) continue;
    PreprocessingParameters parameters;
    Cloud plain, expected, cloud;
    DepthBackprojection<PointFused> host;
    host.setCamera(frame.rig.cameras[0]);
    host.setView(frame.rig.views[0]);
    host.filter(plain);
    parameters.bilateral = true;
    parameters.bilateral_sigma_s = random.uniform(0.6f, 9.0f);
    parameters.bilateral_sigma_r = random.uniform(0.005f, 0.3f);
    if (k % 3 == 0) parameters.fill_neighbours = 5;
    DepthBackprojection<PointFused, device::Thrust> device;
    for (DepthBackprojection<PointFused>* filter : {&host, static_cast<DepthBackprojection<PointFused>*>(&device)}) {
      filter->setCamera(frame.rig.cameras[0]);
      filter->setView(frame.rig.views[0]);
      filter->setParameters(parameters);
      filter->setUserFilterValue(-1);
      filter->filter(filter == &host ? expected : cloud);
    }
    expectSameBytes(expected, cloud);
    for (std::size_t p = 0; p < plain.size(); ++p) changed += plain[p].z != expected[p].z ? 1 : 0;
  }
  EXPECT_GT(changed, enough(10000));
}

}  // namespace
