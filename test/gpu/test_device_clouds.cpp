// Filters that hand clouds to each other on the device, beside the same filters on the host.

#include "../test_length.h"
#include "device_comparison.h"
#include "random_rig.h"

#include <fuse_flow/gpu/filters/adaptive_hash_fusion.h>
#include <fuse_flow/gpu/filters/confidence_estimation.h>
#include <fuse_flow/gpu/filters/depth_backprojection.h>
#include <fuse_flow/gpu/filters/multi_view_consistency.h>

#include <pcl/exceptions.h>
#include <pcl/for_each_type.h>

#include <limits>
#include <numeric>

namespace {

using namespace fuse_flow;
using device_comparison::Cloud;
using random_rig::Random;
using random_rig::RandomFrame;

template <typename PointT>
using OnDevice = gpu::DeviceCloud<PointT>;

template <typename PointT>
typename OnDevice<PointT>::Ptr upload(const pcl::PointCloud<PointT>& cloud) {
  auto result = std::make_shared<OnDevice<PointT>>();
  result->upload(cloud);
  return result;
}

template <typename PointT>
pcl::PointCloud<PointT> download(const OnDevice<PointT>& cloud) {
  pcl::PointCloud<PointT> result;
  cloud.download(result);
  return result;
}

/** \brief Compares one registered field of two points, bit by bit. */
template <typename PointT>
struct SameField {
  const PointT &a, &b;
  bool& same;
  template <typename Field>
  void operator()() {
    constexpr std::size_t offset = pcl::traits::offset<PointT, Field>::value;
    using Value = typename pcl::traits::datatype<PointT, Field>::type;
    same &= std::memcmp(reinterpret_cast<const char*>(&a) + offset, reinterpret_cast<const char*>(&b) + offset,
                        sizeof(Value)) == 0;
  }
};

template <typename PointT>
void expectSamePoints(const pcl::PointCloud<PointT>& host, const pcl::PointCloud<PointT>& device) {
  ASSERT_EQ(device.size(), host.size());
  EXPECT_EQ(device.width, host.width);
  EXPECT_EQ(device.height, host.height);
  EXPECT_EQ(device.is_dense, host.is_dense);
  EXPECT_EQ(device.header.stamp, host.header.stamp);
  EXPECT_EQ(device.header.frame_id, host.header.frame_id);
  EXPECT_EQ(device.sensor_origin_, host.sensor_origin_);
  EXPECT_EQ(device.sensor_orientation_.coeffs(), host.sensor_orientation_.coeffs());
  std::size_t different = 0;
  for (std::size_t k = 0; k < host.size(); ++k) {
    bool same = true;
    pcl::for_each_type<typename pcl::traits::fieldList<PointT>::type>(SameField<PointT>{host[k], device[k], same});
    different += same ? 0 : 1;
  }
  EXPECT_EQ(different, 0u) << "of " << host.size();
}

/** \brief Organised clouds of the cameras that measured, with fields that are not fused filled in. */
template <typename PointT>
std::vector<typename pcl::PointCloud<PointT>::Ptr> cloudsOf(const RigFrame& frame, Random& random) {
  std::vector<typename pcl::PointCloud<PointT>::Ptr> clouds;
  DepthBackprojection<PointT> backprojection;
  for (std::size_t i = 0; i < frame.cameras.size(); ++i) {
    auto cloud = std::make_shared<pcl::PointCloud<PointT>>();
    if (!frame.views[i].missing() && frame.cameras[i].intrinsics.height > 1) {
      backprojection.setCamera(frame.cameras[i]);
      backprojection.setView(frame.views[i]);
      backprojection.filter(*cloud);
      for (PointT& point : *cloud) {
        point::setConfidence(point, random.uniform(0.0f, 1.2f));  // what is over 1 counts as 1
        const float z = random.oneIn(5) ? std::numeric_limits<float>::quiet_NaN() : 0.5f;
        point::setNormal(point, {random.uniform(-1.0f, 1.0f), random.uniform(-1.0f, 1.0f), z});
      }
      cloud->header.frame_id = "world";
      cloud->header.stamp = frame.stamp;
    }
    clouds.push_back(cloud);
  }
  return clouds;
}

/** \brief view_count of a point, 0 where it has none. */
template <typename PointT>
std::uint32_t countOf(const PointT& point) {
  if constexpr (point::has_view_count<PointT>) return point::getField<pcl::fields::view_count, std::uint32_t>(point);
  return 0;
}

/** \brief Some of n indices in any order, a few of them twice. */
pcl::IndicesPtr someIndices(Random& random, std::size_t n) {
  auto indices = std::make_shared<pcl::Indices>();
  for (std::size_t k = 0; k < n / 2; ++k) indices->push_back(random.below(static_cast<int>(n)));
  return indices;
}

/** \brief Combination k of the settings of pcl::FilterIndices. */
template <typename Filter>
void applySettings(Filter& filter, int k, const pcl::IndicesPtr& indices) {
  filter.setNegative(k & 1);
  filter.setKeepOrganized(k & 2);
  filter.setUserFilterValue(k & 4 ? -3.0f : std::numeric_limits<float>::quiet_NaN());
  if (k & 8) filter.setIndices(indices);
}

template <typename PointT>
class DeviceClouds : public testing::Test {};
#if defined(FUSE_FLOW_TEST_FEW_POINT_TYPES)  // under sanitizers
using PointTypes = testing::Types<PointFused, pcl::PointXYZ>;
#else
using PointTypes = testing::Types<PointFused, PointFusedCameras, pcl::PointXYZ, pcl::PointXYZI, pcl::PointXYZRGBNormal,
                                  pcl::PointSurfel>;
#endif
TYPED_TEST_SUITE(DeviceClouds, PointTypes);

TYPED_TEST(DeviceClouds, UploadAndDownloadKeepEverything) {
  Random random(70);
  RandomFrame frame;
  for (int k = 0; k < 5; ++k) {
    frame.draw(random);
    for (const auto& cloud : cloudsOf<TypeParam>(frame.rig, random))
      expectSamePoints(*cloud, download(*upload(*cloud)));
  }
}

TYPED_TEST(DeviceClouds, ConfidenceEstimationIsTheHosts) {
  Random random(71);
  RandomFrame frame;
  std::size_t kept = 0;
  for (int k = 0; k < timesOver(48, 16); ++k) {
    frame.draw(random, 1);
    const auto cloud = cloudsOf<TypeParam>(frame.rig, random)[0];
    if (cloud->empty()) continue;
    const pcl::IndicesPtr indices = someIndices(random, cloud->size());
    ConfidenceEstimation<TypeParam> host(true);
    ConfidenceEstimation<TypeParam, device::Thrust> device(true);
    ConfidenceParameters parameters;
    parameters.form = k % 3 ? ConfidenceForm::Published : ConfidenceForm::SlopeCompensated;
    const auto configure = [&](auto& filter) {
      filter.setParameters(parameters);
      filter.setFocalLength(frame.rig.cameras[0].intrinsics.fx);
      applySettings(filter, k, indices);
    };
    configure(host);
    configure(device);
    pcl::PointCloud<TypeParam> expected;
    host.setInputCloud(cloud);
    host.filter(expected);
    OnDevice<TypeParam> result;
    device.setInputCloud(upload(*cloud));
    device.filter(result);
    expectSamePoints(expected, download(result));
    EXPECT_EQ(*device.getRemovedIndices(), *host.getRemovedIndices());
    kept += result.size();
  }
  EXPECT_GT(kept, enough(1000));
}

TYPED_TEST(DeviceClouds, DepthBackprojectionIsTheHosts) {
  Random random(72);
  RandomFrame frame;
  for (int k = 0; k < timesOver(48, 16); ++k) {
    frame.draw(random, 1);
    if (frame.rig.views[0].missing()) continue;
    const Intrinsics& K = frame.rig.cameras[0].intrinsics;
    const pcl::IndicesPtr indices = someIndices(random, static_cast<std::size_t>(K.width * K.height));
    PreprocessingParameters parameters;
    if (k & 1) parameters.fill_neighbours = 4;
    parameters.bilateral = k % 5 == 0;
    DepthBackprojection<TypeParam> host(true);
    DepthBackprojection<TypeParam, device::Thrust> device(true);
    const auto configure = [&](auto& filter) {
      filter.setCamera(frame.rig.cameras[0]);
      filter.setView(frame.rig.views[0]);
      filter.setParameters(parameters);
      if (k & 4) filter.setUserFilterValue(-1);
      if (k & 8) filter.setIndices(indices);
    };
    configure(host);
    configure(device);
    pcl::PointCloud<TypeParam> expected;
    host.filter(expected);
    OnDevice<TypeParam> result;
    device.filter(result);
    expectSamePoints(expected, download(result));
    EXPECT_EQ(*device.getRemovedIndices(), *host.getRemovedIndices());

    // The same from a cloud in the camera's frame, whose other fields stay.
    const auto cloud = std::make_shared<pcl::PointCloud<TypeParam>>(expected);
    for (TypeParam& point : *cloud) {
      point.z = random.oneIn(9) ? std::numeric_limits<float>::quiet_NaN() : random.uniform(0.5f, 3.0f);
      point::setConfidence(point, random.uniform(0.0f, 1.0f));
      point::setNormal(point, {random.uniform(-1.0f, 1.0f), random.uniform(-1.0f, 1.0f), 0.5f});
    }
    cloud->header.frame_id = "camera";
    host.setInputCloud(cloud);
    device.setInputCloud(upload(*cloud));
    host.filter(expected);
    device.filter(result);
    expectSamePoints(expected, download(result));
    EXPECT_EQ(*device.getRemovedIndices(), *host.getRemovedIndices());
  }
}

TYPED_TEST(DeviceClouds, MultiViewConsistencyIsTheHosts) {
  Random random(73);
  RandomFrame frame;
  std::size_t points = 0;
  for (int k = 0; k < timesOver(48, 16); ++k) {
    frame.draw(random);
    const auto clouds = cloudsOf<TypeParam>(frame.rig, random);
    const auto source = static_cast<std::size_t>(random.below(static_cast<int>(clouds.size())));
    if (clouds[source]->empty()) continue;
    const pcl::IndicesPtr indices = someIndices(random, clouds[source]->size());
    const ConsistencyParameters parameters = random_rig::parameters(random).consistency;
    MultiViewConsistency<TypeParam> host(true);
    MultiViewConsistency<TypeParam, device::Thrust> device(true);
    const auto configure = [&](auto& filter) {
      filter.setFrame(frame.rig, k % 3 ? static_cast<int>(source) : -1);
      filter.setParameters(parameters);
      applySettings(filter, k, indices);
    };
    configure(host);
    configure(device);
    pcl::PointCloud<TypeParam> expected;
    host.setInputCloud(clouds[source]);
    host.filter(expected);
    OnDevice<TypeParam> result;
    device.setInputCloud(upload(*clouds[source]));
    device.filter(result);
    // exp() may differ in its last bit, on a GPU: then so do V and confidence.
    const pcl::PointCloud<TypeParam> downloaded = download(result);
    ASSERT_EQ(downloaded.size(), expected.size());
    EXPECT_EQ(*device.getRemovedIndices(), *host.getRemovedIndices());
    EXPECT_EQ(downloaded.width, expected.width);
    EXPECT_EQ(downloaded.is_dense, expected.is_dense);
    for (std::size_t p = 0; p < expected.size(); ++p) {
      EXPECT_EQ(std::memcmp(&downloaded[p].x, &expected[p].x, 12), 0) << p;
      if constexpr (point::has_confidence<TypeParam>) {
        EXPECT_NEAR(downloaded[p].confidence, expected[p].confidence, 1e-5f);
      }
    }
    points += expected.size();
  }
  EXPECT_GT(points, enough(1000));
}

TYPED_TEST(DeviceClouds, AdaptiveHashFusionIsTheHosts) {
  Random random(74);
  RandomFrame frame;
  std::size_t points = 0, alone = 0, removed = 0, removed_alone = 0;
  // The points of a coarse cell come in another order.
  const auto same = [](const TypeParam& a, const TypeParam& b) {
    return device_comparison::samePosition(a, b) && squaredNorm(point::getColor(a) - point::getColor(b)) <= 3 &&
           (squaredNorm(point::getNormal(a) - point::getNormal(b)) < 1e-6f ||
            (!isFinite(point::getNormal(a)) && !isFinite(point::getNormal(b)))) &&
           std::fabs(point::getIntensity(a) - point::getIntensity(b)) < 0.01f &&
           std::fabs(point::getConfidence(a) - point::getConfidence(b)) < 1e-4f && countOf(a) == countOf(b) &&
           point::getCameraMask(a) == point::getCameraMask(b);
  };
  for (int k = 0; k < timesOver(60, 12); ++k) {
    frame.draw(random);
    const auto clouds = cloudsOf<TypeParam>(frame.rig, random);
    auto all = std::make_shared<pcl::PointCloud<TypeParam>>();
    std::vector<std::uint32_t> cameras;
    std::vector<typename OnDevice<TypeParam>::ConstPtr> on_device;
    for (std::uint32_t i = 0; i < clouds.size(); ++i) {
      *all += *clouds[i];
      cameras.resize(all->size(), i);
      on_device.push_back(clouds[i]->empty() && k % 2 ? nullptr : upload(*clouds[i]));
    }
    if (all->empty()) continue;
    auto indices = std::make_shared<pcl::Indices>();
    for (std::size_t p = 0; p < all->size(); ++p)
      if (!random.oneIn(3)) indices->push_back(static_cast<pcl::index_t>(p));
    const FuseFlowParameters parameters = random_rig::parameters(random);
    AdaptiveHashFusion<TypeParam> host(true);
    AdaptiveHashFusion<TypeParam, device::Thrust> device(true);
    const auto configure = [&](auto& filter) {
      filter.setParameters(parameters.aggregation);
      if (k % 3 == 2) filter.setFrame(frame.rig, parameters.consistency);
      if (k % 3 == 2) filter.setPreprocessing(parameters.preprocessing);
      if (k % 4 == 3) filter.setIndices(indices);
    };
    configure(host);
    configure(device);
    pcl::PointCloud<TypeParam> expected;
    host.setInputCloud(all);
    host.setCameraIndices(cameras);
    host.filter(expected);
    OnDevice<TypeParam> result;
    device.setInputClouds(on_device);
    device.filter(result);
    const pcl::PointCloud<TypeParam> downloaded = download(result);
    alone += device_comparison::pointsAlone(expected, downloaded, same);
    points += expected.size() + downloaded.size();
    removed += host.getRemovedIndices()->size() + device.getRemovedIndices()->size();
    removed_alone += device_comparison::indicesAlone(*host.getRemovedIndices(), *device.getRemovedIndices());
  }
  EXPECT_GT(points, enough(4000));
  EXPECT_LE(alone * 10000, points) << alone << " of " << points;
  EXPECT_GT(removed, enough(20000));
  EXPECT_LE(removed_alone * 10000, removed) << removed_alone << " of " << removed;
}

/** \brief Images in, fused cloud out, through all four filters. */
template <typename Filters, typename Handle>
void chain(Filters& filters, const RigFrame& frame, std::vector<Handle>& clouds, const Handle& output) {
  for (std::size_t i = 0; i < frame.cameras.size(); ++i) {
    clouds[i] = std::make_shared<typename Handle::element_type>();
    if (frame.views[i].missing() || frame.cameras[i].intrinsics.height < 2) continue;
    filters.backprojection.setCamera(frame.cameras[i]);
    filters.backprojection.setView(frame.views[i]);
    filters.backprojection.filter(*clouds[i]);
    filters.confidence.setFocalLength(frame.cameras[i].intrinsics.fx);
    filters.confidence.setInputCloud(clouds[i]);
    filters.confidence.filter(*clouds[i]);  // in place
    filters.consistency.setFrame(frame, static_cast<int>(i));
    filters.consistency.setInputCloud(clouds[i]);
    filters.consistency.filter(*clouds[i]);
  }
  filters.fuse(clouds, *output);
}

struct HostFilters {
  DepthBackprojection<PointFused> backprojection;
  ConfidenceEstimation<PointFused> confidence;
  MultiViewConsistency<PointFused> consistency;
  AdaptiveHashFusion<PointFused> fusion;

  void fuse(const std::vector<Cloud::Ptr>& clouds, Cloud& output) {
    auto all = std::make_shared<Cloud>();
    std::vector<std::uint32_t> cameras;
    for (std::uint32_t i = 0; i < clouds.size(); ++i) {
      *all += *clouds[i];
      cameras.resize(all->size(), i);
    }
    fusion.setInputCloud(all);
    fusion.setCameraIndices(cameras);
    fusion.filter(output);
  }
};

struct DeviceFilters {
  DepthBackprojection<PointFused, device::Thrust> backprojection;
  ConfidenceEstimation<PointFused, device::Thrust> confidence;
  MultiViewConsistency<PointFused, device::Thrust> consistency;
  AdaptiveHashFusion<PointFused, device::Thrust> fusion;

  void fuse(const std::vector<OnDevice<PointFused>::Ptr>& clouds, OnDevice<PointFused>& output) {
    fusion.setInputClouds({clouds.begin(), clouds.end()});
    fusion.filter(output);
  }
};

TEST(DeviceCloudChain, GivesTheHostsCloud) {
  Random random(75);
  RandomFrame frame;
  HostFilters host;
  DeviceFilters device;
  device_comparison::Tally tally;
  for (int k = 0; k < timesOver(40, 4); ++k) {
    frame.draw(random);
    std::vector<Cloud::Ptr> clouds(frame.rig.cameras.size());
    std::vector<OnDevice<PointFused>::Ptr> device_clouds(frame.rig.cameras.size());
    const auto expected = std::make_shared<Cloud>();
    const auto result = std::make_shared<OnDevice<PointFused>>();
    bool any = false;
    for (const DepthView& view : frame.rig.views) any |= !view.missing();
    if (!any) continue;
    chain(host, frame.rig, clouds, expected);
    chain(device, frame.rig, device_clouds, result);
    tally.add(*expected, download(*result), AggregationParameters().cell_size);
  }
  EXPECT_GT(tally.points, enough(3000));
  EXPECT_TRUE(tally.good()) << tally;
}

TEST(DeviceCloudChain, BeginsAndEndsInDeviceMemory) {
  Random random(76);
  RandomFrame frame;
  do frame.draw(random, 1);
  while (!frame.rig.views[0].depth16 || frame.rig.cameras[0].intrinsics.height < 2);
  DepthBackprojection<PointFused, device::Thrust> filter;
  filter.setCamera(frame.rig.cameras[0]);
  filter.setView(frame.rig.views[0]);
  OnDevice<PointFused> from_host, from_device;
  filter.filter(from_host);
  gpu::Execution run;
  gpu::DeviceBuffer<std::uint16_t> depth;
  DepthView view = frame.rig.views[0];
  view.color = {};
  const std::size_t size = from_host.size();
  depth.resize(size);
  run.copy(depth.data(), view.depth16.data, size);
  run.wait();
  view.depth16.data = depth.data();
  filter.setView(view);
  filter.filter(from_device);
  const Cloud a = download(from_host), b = download(from_device);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) EXPECT_EQ(std::memcmp(&a[k].x, &b[k].x, 12), 0);
}

TEST(DeviceCloudChain, TheFramePipelineLeavesACloud) {
  Random random(77);
  RandomFrame frame;
  FuseFlow<PointFused, device::Thrust> fusion;
  OnDevice<PointFused> on_device;
  for (int k = 0; k < 5; ++k) {
    frame.draw(random);
    Cloud expected;
    fusion.fuse(frame.rig, expected);
    fusion.fuse(frame.rig, on_device);
    expectSamePoints(expected, download(on_device));
    EXPECT_EQ(fusion.getStatistics().fused_points, expected.size());
  }
}

TEST(DeviceCloudChain, OnceWarmItAllocatesNothing) {
  Random random(78);
  RandomFrame frame;
  do frame.draw(random, 4);
  while (frame.rig.cameras.size() < 3 || frame.rig.views[0].missing() || frame.rig.views[1].missing());
  DeviceFilters filters;
  std::vector<OnDevice<PointFused>::Ptr> clouds(2);
  OnDevice<PointFused> output;
  std::vector<const void*> seen;
  for (OnDevice<PointFused>::Ptr& cloud : clouds) cloud = std::make_shared<OnDevice<PointFused>>();
  for (int k = 0; k < 40; ++k) {
    for (std::size_t i = 0; i < clouds.size(); ++i) {
      filters.backprojection.setCamera(frame.rig.cameras[i]);
      filters.backprojection.setView(frame.rig.views[i]);
      filters.backprojection.filter(*clouds[i]);
    }
    filters.fuse(clouds, output);
    for (const OnDevice<PointFused>* cloud : {clouds[0].get(), clouds[1].get(), &output}) {
      const bool known = std::find(seen.begin(), seen.end(), cloud->data()) != seen.end();
      if (!known && k < 20) seen.push_back(cloud->data());
      EXPECT_TRUE(known || k < 20) << k;
    }
  }
}

TEST(DeviceCloudErrors, AreThoseOfTheHost) {
  const auto row = std::make_shared<OnDevice<PointFused>>();
  row->upload(Cloud(5, 1));
  OnDevice<PointFused> output;
  ConfidenceEstimation<PointFused, device::Thrust> confidence;
  EXPECT_THROW(confidence.filter(output), pcl::PCLException);
  confidence.setInputCloud(row);
  EXPECT_THROW(confidence.filter(output), pcl::UnorganizedPointCloudException);

  MultiViewConsistency<PointFused, device::Thrust> consistency;
  consistency.setInputCloud(row);
  EXPECT_THROW(consistency.filter(output), pcl::BadArgumentException);  // no frame

  Camera camera;
  camera.name = "only";
  camera.intrinsics.width = 3;
  camera.intrinsics.height = 2;
  camera.intrinsics.fx = camera.intrinsics.fy = 3;
  DepthBackprojection<PointFused, device::Thrust> backprojection;
  backprojection.setCamera(camera);
  EXPECT_THROW(backprojection.filter(output), pcl::PCLException);  // neither view nor cloud
  backprojection.setInputCloud(row);
  EXPECT_THROW(backprojection.filter(output), pcl::BadArgumentException);  // 5x1
  const auto fitting = std::make_shared<OnDevice<PointFused>>();
  fitting->upload(Cloud(3, 2));
  backprojection.setInputCloud(fitting);
  backprojection.filter(output);
  backprojection.setView({});  // a camera that misses this frame: not the cloud of an earlier one
  EXPECT_THROW(backprojection.filter(output), pcl::PCLException);

  AdaptiveHashFusion<PointFused, device::Thrust> fusion;
  EXPECT_THROW(fusion.filter(output), pcl::PCLException);
  RigFrame frame;
  frame.cameras = {camera};
  frame.views.resize(1);
  fusion.setFrame(frame);
  fusion.setInputClouds({row, row});
  EXPECT_THROW(fusion.filter(output), pcl::BadArgumentException);  // two clouds, one camera
  fusion.setInputCloud(row);
  fusion.setIndices(std::make_shared<pcl::Indices>(pcl::Indices{5}));
  EXPECT_THROW(fusion.filter(output), pcl::BadArgumentException);

  AdaptiveHashFusion<PointFused, device::Thrust> far;
  Cloud away(2, 1);
  for (PointFused& point : away) point.x = point.y = point.z = point.confidence = 1;
  away[1].y = 1e7f;
  far.setInputCloud(upload(away));
  try {
    far.filter(output);
    ADD_FAILURE() << "a point 10^7 m away went unnoticed";
  } catch (const pcl::PCLException& error) {
    EXPECT_NE(std::string(error.what()).find("1e+07"), std::string::npos) << error.what();
  }
}

TEST(DeviceCloudErrors, NothingInIsNothingOut) {
  OnDevice<PointFused> output;
  output.upload(Cloud(5, 1));
  AdaptiveHashFusion<PointFused, device::Thrust> fusion(true);
  fusion.setInputClouds({nullptr, std::make_shared<OnDevice<PointFused>>()});
  fusion.filter(output);
  EXPECT_TRUE(output.empty());
  EXPECT_TRUE(fusion.getRemovedIndices()->empty());
  ConfidenceEstimation<PointFused, device::Thrust> confidence;
  confidence.setInputCloud(std::make_shared<OnDevice<PointFused>>());
  confidence.filter(output);
  EXPECT_TRUE(output.empty());
}

}  // namespace
