#include "filter_conformance.h"

#include <fuse_flow/filters/adaptive_hash_fusion.h>
#include <fuse_flow/filters/depth_backprojection.h>

#include <gtest/gtest.h>

#include <numeric>
#include <random>

namespace {

using namespace fuse_flow;
using namespace filter_conformance;

template <typename P>
class AdaptiveHashFusionOf : public ::testing::Test {};

TYPED_TEST_SUITE(AdaptiveHashFusionOf, PointTypes, PointName);

/** \brief A grid of points 20 mm apart on the plane z = 1, C = 0.8. */
template <typename P>
typename pcl::PointCloud<P>::Ptr planeOf() {
  auto cloud = std::make_shared<pcl::PointCloud<P>>();
  for (int i = 0; i < 400; ++i) {
    cloud->push_back(distinctPoint<P>(0.02f * static_cast<float>(i % 20) - 0.2f,
                                      0.02f * static_cast<float>(i / 20) - 0.2f, 1.0f, i));
    setConfidence(cloud->back(), 0.8f);
  }
  addHeaderAndPose(*cloud);
  return cloud;
}

template <typename P>
pcl::PointCloud<P> fused(AdaptiveHashFusion<P>& filter, const typename pcl::PointCloud<P>::ConstPtr& cloud) {
  pcl::PointCloud<P> output;
  filter.setInputCloud(cloud);
  filter.filter(output);
  return output;
}

template <typename P>
pcl::PointCloud<P> fused(const typename pcl::PointCloud<P>::ConstPtr& cloud) {
  AdaptiveHashFusion<P> filter;
  return fused(filter, cloud);
}

/** \brief Two points of cameras 0 and 1 in one cell, of which the first has three times the weight where there is any. */
template <typename P>
typename pcl::PointCloud<P>::Ptr twoPointsInACell() {
  auto cloud = std::make_shared<pcl::PointCloud<P>>();
  cloud->push_back(distinctPoint<P>(0.101f, 0.101f, 1.001f, 1));
  cloud->push_back(distinctPoint<P>(0.105f, 0.109f, 1.005f, 2));
  setConfidence((*cloud)[0], 0.9f);
  setConfidence((*cloud)[1], 0.3f);
  return cloud;
}

TYPED_TEST(AdaptiveHashFusionOf, OfAPlaneStaysInsideItsHull) {
  const auto output = fused<TypeParam>(planeOf<TypeParam>());
  ASSERT_GT(output.size(), 40u);  // a cell each 64 mm at the very least
  ASSERT_LE(output.size(), 400u);
  for (const TypeParam& p : output) {
    EXPECT_NEAR(p.z, 1.0f, 1e-6f);
    EXPECT_GE(p.x, -0.2f - 1e-6f);
    EXPECT_LE(p.x, 0.18f + 1e-6f);
    EXPECT_GE(p.y, -0.2f - 1e-6f);
    EXPECT_LE(p.y, 0.18f + 1e-6f);
  }
  EXPECT_EQ(output.width, output.size());
  EXPECT_EQ(output.height, 1u);
  EXPECT_TRUE(output.is_dense);
}

TYPED_TEST(AdaptiveHashFusionOf, WritesTheWeightToConfidenceAndToIntensityWhereThatIsSaid) {
  AdaptiveHashFusion<TypeParam> filter;
  filter.setWeightInIntensity(true);
  const auto output = fused(filter, planeOf<TypeParam>());
  ASSERT_FALSE(output.empty());
  for (const TypeParam& p : output) {
    if constexpr (hasConfidence<TypeParam>) {
      EXPECT_NEAR(confidenceOf(p), 0.8f, 1e-5f);
    }
    if constexpr (point::has_intensity<TypeParam>) {
      EXPECT_NEAR(point::getIntensity(p), hasConfidence<TypeParam> ? 0.8f : 1.0f, 1e-5f);
    }
    if constexpr (point::has_view_count<TypeParam>) {
      EXPECT_EQ(p.view_count, 1u);
    }
  }
}

TYPED_TEST(AdaptiveHashFusionOf, CarriesHeaderAndSensorPoseOver) {
  expectHeaderAndPose(fused<TypeParam>(planeOf<TypeParam>()));
}

TYPED_TEST(AdaptiveHashFusionOf, FiltersInPlace) {
  const auto cloud = planeOf<TypeParam>();
  AdaptiveHashFusion<TypeParam> filter;
  const auto elsewhere = fused(filter, cloud);
  filter.filter(*cloud);
  EXPECT_TRUE(sameClouds(*cloud, elsewhere));
  expectHeaderAndPose(*cloud);
}

TYPED_TEST(AdaptiveHashFusionOf, OfAnEmptyCloudIsEmpty) {
  AdaptiveHashFusion<TypeParam> filter(true);
  filter.setInputCloud(std::make_shared<pcl::PointCloud<TypeParam>>());
  pcl::PointCloud<TypeParam> output = *planeOf<TypeParam>();
  ASSERT_NO_THROW(filter.filter(output));
  EXPECT_TRUE(output.empty());
  EXPECT_TRUE(filter.getRemovedIndices()->empty());
}

TYPED_TEST(AdaptiveHashFusionOf, SkipsPointsThatAreNotFinite) {
  const auto cloud = planeOf<TypeParam>();
  const auto clean = fused<TypeParam>(cloud);
  for (const float bad : {kNaN, kInf, -kInf}) {
    cloud->push_back(distinctPoint<TypeParam>(bad, 0, 1, 1));
    cloud->insert(cloud->begin(), distinctPoint<TypeParam>(0, bad, 1, 1));
    cloud->insert(cloud->begin() + 100, distinctPoint<TypeParam>(0, 0, bad, 1));
  }
  cloud->is_dense = false;
  const auto output = fused<TypeParam>(cloud);
  EXPECT_TRUE(sameClouds(output, clean));
  EXPECT_TRUE(output.is_dense);
}

TYPED_TEST(AdaptiveHashFusionOf, SkipsPointsWithoutConfidence) {
  if constexpr (!hasConfidence<TypeParam>) {
    GTEST_SKIP() << "no confidence field";
  } else {
    const auto cloud = planeOf<TypeParam>();
    const auto clean = fused<TypeParam>(cloud);
    for (const float C : {0.0f, -1.0f, kNaN}) {
      cloud->push_back(distinctPoint<TypeParam>(0.001f, 0.001f, 1.01f, 1));
      setConfidence(cloud->back(), C);
    }
    EXPECT_TRUE(sameClouds(fused<TypeParam>(cloud), clean));
  }
}

TYPED_TEST(AdaptiveHashFusionOf, HonoursIndices) {
  const auto cloud = planeOf<TypeParam>();
  const auto half = std::make_shared<pcl::PointCloud<TypeParam>>(*cloud, pcl::Indices{3, 4, 5, 30, 200});
  AdaptiveHashFusion<TypeParam> filter;
  filter.setIndices(std::make_shared<pcl::Indices>(pcl::Indices{3, 4, 5, 30, 200}));
  EXPECT_TRUE(sameClouds(fused(filter, cloud), fused<TypeParam>(half)));
}

TYPED_TEST(AdaptiveHashFusionOf, RemovesThePointsThatRepresentNoOutputPoint) {
  // One cell; three of its four points represent it: the most confident ones, or the first ones. The first point is
  // not finite, the last is not among the indices.
  const auto cloud = std::make_shared<pcl::PointCloud<TypeParam>>();
  cloud->push_back(distinctPoint<TypeParam>(kNaN, 0, 1, 1));
  for (const float C : {0.2f, 0.5f, 0.7f, 0.9f, 0.95f}) {
    cloud->push_back(distinctPoint<TypeParam>(0.01f + 0.01f * C, 0.01f, 0.01f, 1));
    setConfidence(cloud->back(), C);
  }
  cloud->is_dense = false;
  AggregationParameters parameters;
  parameters.points_per_cell = 6;
  parameters.representatives = Representatives::HighestConfidence;
  for (const bool extract : {true, false}) {
    AdaptiveHashFusion<TypeParam> filter(extract);
    filter.setParameters(parameters);
    filter.setIndices(std::make_shared<pcl::Indices>(pcl::Indices{0, 1, 2, 3, 4}));
    EXPECT_EQ(fused(filter, cloud).size(), 1u);
    const pcl::Indices expected{0, hasConfidence<TypeParam> ? 1 : 4};
    EXPECT_EQ(*filter.getRemovedIndices(), extract ? expected : pcl::Indices());
  }
}

TYPED_TEST(AdaptiveHashFusionOf, NamesAPointThatIsTooFarOut) {
  const auto cloud = planeOf<TypeParam>();
  cloud->push_back(distinctPoint<TypeParam>(0.5f, 1e7f, 0.25f, 1));
  AdaptiveHashFusion<TypeParam> filter;
  expectThrow<pcl::PCLException>([&] { fused(filter, cloud); }, {"AdaptiveHashFusion", "(0.5, 1e+07, 0.25)"});
}

TYPED_TEST(AdaptiveHashFusionOf, OfTwoPointsInACellIsTheirWeightedMeanByHand) {
  AdaptiveHashFusion<TypeParam> filter;
  filter.setCameraIndices({0, 1});
  const auto output = fused(filter, twoPointsInACell<TypeParam>());
  ASSERT_EQ(output.size(), 1u);
  const float share = hasConfidence<TypeParam> ? 0.25f : 0.5f;  // of the second
  EXPECT_NEAR(output[0].x, 0.101f + share * 0.004f, 1e-6f);
  EXPECT_NEAR(output[0].y, 0.101f + share * 0.008f, 1e-6f);
  EXPECT_NEAR(output[0].z, 1.001f + share * 0.004f, 1e-6f);
  // Σ ω² / Σ ω = (0.81 + 0.09) / 1.2.
  if constexpr (hasConfidence<TypeParam>) {
    EXPECT_NEAR(confidenceOf(output[0]), 0.75f, 1e-5f);
  }
  if constexpr (point::has_view_count<TypeParam>) {
    EXPECT_EQ(output[0].view_count, 2u);
  }
}

TYPED_TEST(AdaptiveHashFusionOf, CarriesTheFieldsItDoesNotKnowFromTheMainRepresentative) {
  if constexpr (!hasConfidence<TypeParam>) {
    GTEST_SKIP() << "no confidence field: both points weigh the same";
  } else {
    const auto cloud = twoPointsInACell<TypeParam>();
    for (const bool swap : {false, true}) {
      if (swap) std::swap((*cloud)[0], (*cloud)[1]);
      AdaptiveHashFusion<TypeParam> filter;
      filter.setCameraIndices({0, 1});
      const auto output = fused(filter, cloud);
      ASSERT_EQ(output.size(), 1u);
      const TypeParam& main = (*cloud)[swap ? 1 : 0];
      if constexpr (std::is_same_v<TypeParam, OddPoint>) {
        EXPECT_EQ(output[0].m_warmth, main.m_warmth);
        EXPECT_EQ(output[0].m_serial, main.m_serial);
      }
      if constexpr (std::is_same_v<TypeParam, pcl::PointSurfel>) {
        EXPECT_EQ(output[0].radius, main.radius);
        EXPECT_EQ(output[0].curvature, main.curvature);
      }
    }
  }
}

TYPED_TEST(AdaptiveHashFusionOf, AveragesColourByHand) {
  if constexpr (!point::has_color<TypeParam>) {
    GTEST_SKIP() << "no colour field";
  } else {
    const auto cloud = twoPointsInACell<TypeParam>();
    point::setColor((*cloud)[0], {100, 50, 0});
    point::setColor((*cloud)[1], {200, 150, 200});
    AdaptiveHashFusion<TypeParam> filter;
    filter.setCameraIndices({0, 1});
    const auto output = fused(filter, cloud);
    ASSERT_EQ(output.size(), 1u);
    EXPECT_EQ(output[0].r, hasConfidence<TypeParam> ? 125 : 150);
    EXPECT_EQ(output[0].g, hasConfidence<TypeParam> ? 75 : 100);
    EXPECT_EQ(output[0].b, hasConfidence<TypeParam> ? 50 : 100);
    EXPECT_EQ(output[0].a, 255);
  }
}

TYPED_TEST(AdaptiveHashFusionOf, AveragesNormalsByHandToUnitLength) {
  if constexpr (!point::has_normal<TypeParam>) {
    GTEST_SKIP() << "no normal";
  } else {
    const auto cloud = twoPointsInACell<TypeParam>();
    point::setNormal((*cloud)[0], {0, 0, -1});
    point::setNormal((*cloud)[1], {0, -1, 0});
    AdaptiveHashFusion<TypeParam> filter;
    filter.setCameraIndices({0, 1});
    const auto output = fused(filter, cloud);
    ASSERT_EQ(output.size(), 1u);
    const float first = hasConfidence<TypeParam> ? 0.75f : 0.5f;
    const float norm = std::sqrt(first * first + (1 - first) * (1 - first));
    EXPECT_NEAR(output[0].normal_x, 0, 1e-6f);
    EXPECT_NEAR(output[0].normal_y, -(1 - first) / norm, 1e-5f);
    EXPECT_NEAR(output[0].normal_z, -first / norm, 1e-5f);
  }
}

TYPED_TEST(AdaptiveHashFusionOf, ANormalThatIsNotKnownLeavesTheOthers) {
  if constexpr (!point::has_normal<TypeParam>) {
    GTEST_SKIP() << "no normal";
  } else {
    const auto cloud = twoPointsInACell<TypeParam>();
    for (const std::size_t unknown : {0u, 1u}) {
      point::setNormal((*cloud)[unknown], {kNaN, kNaN, kNaN});
      point::setNormal((*cloud)[1 - unknown], {0, -3, 0});
      AdaptiveHashFusion<TypeParam> filter;
      filter.setCameraIndices({0, 1});
      const auto output = fused(filter, cloud);
      ASSERT_EQ(output.size(), 1u);
      EXPECT_EQ(output[0].normal_x, 0.0f);
      EXPECT_NEAR(output[0].normal_y, -1.0f, 1e-6f);
      EXPECT_EQ(output[0].normal_z, 0.0f);
    }
  }
}

TYPED_TEST(AdaptiveHashFusionOf, ConfidenceOverOneCountsAsOne) {
  if constexpr (!hasConfidence<TypeParam>) {
    GTEST_SKIP() << "no confidence field";
  } else {
    const auto cloud = twoPointsInACell<TypeParam>();
    setConfidence((*cloud)[0], 5.0f);
    setConfidence((*cloud)[1], kInf);
    AdaptiveHashFusion<TypeParam> filter;
    filter.setCameraIndices({0, 1});
    const auto output = fused(filter, cloud);
    ASSERT_EQ(output.size(), 1u);
    EXPECT_NEAR(output[0].x, 0.103f, 1e-6f);  // half way between them
    EXPECT_EQ(confidenceOf(output[0]), 1.0f);
  }
}

/** \brief Points scattered over a crumpled sheet, with confidences that are all different and none of them weak. */
pcl::PointCloud<PointFused>::Ptr scattered(std::size_t count) {
  auto cloud = std::make_shared<pcl::PointCloud<PointFused>>();
  std::mt19937 random(11);
  std::uniform_real_distribution<float> place(-1.0f, 1.0f);
  for (std::size_t i = 0; i < count; ++i) {
    const float x = place(random), y = place(random);
    cloud->push_back(
        distinctPoint<PointFused>(x, y, 0.3f * std::sin(5 * x) + 0.01f * place(random), static_cast<int>(i % 20)));
    cloud->back().confidence = 0.3f + 0.7f * static_cast<float>(i) / static_cast<float>(count);
  }
  return cloud;
}

constexpr Representatives kAllRepresentatives[] = {Representatives::HighestConfidence,
                                                   Representatives::DifferentCameras, Representatives::CameraMeans};

TEST(AdaptiveHashFusion, DoesNotDependOnTheOrderOfThePoints) {
  const auto cloud = scattered(2000);
  std::vector<std::uint32_t> cameras(cloud->size());
  for (std::size_t i = 0; i < cameras.size(); ++i) cameras[i] = static_cast<std::uint32_t>(i % 5);
  std::vector<std::size_t> order(cloud->size());
  std::iota(order.begin(), order.end(), 0u);
  std::shuffle(order.begin(), order.end(), std::mt19937(5));
  const auto shuffled = std::make_shared<pcl::PointCloud<PointFused>>();
  std::vector<std::uint32_t> shuffled_cameras;
  for (const std::size_t i : order) {
    shuffled->push_back((*cloud)[i]);
    shuffled_cameras.push_back(cameras[i]);
  }
  for (const Representatives mode : kAllRepresentatives) {
    AggregationParameters parameters;
    parameters.representatives = mode;
    AdaptiveHashFusion<PointFused> filter;
    filter.setParameters(parameters);
    filter.setCameraIndices(cameras);
    const auto a = fused(filter, cloud);
    filter.setCameraIndices(shuffled_cameras);
    const auto b = fused(filter, shuffled);
    ASSERT_GT(a.size(), 100u);
    ASSERT_EQ(a.size(), b.size());
    for (const PointFused& p : a)
      EXPECT_TRUE(std::any_of(b.begin(), b.end(), [&](const PointFused& q) {
        return (p.getVector3fMap() - q.getVector3fMap()).norm() < 1e-5f &&
               std::fabs(p.confidence - q.confidence) < 1e-5f && p.view_count == q.view_count;
      }));
  }
}

TEST(AdaptiveHashFusion, GivesTheSameBytesOnAnyNumberOfThreads) {
  const auto cloud = scattered(100000);  // several stretches of work
  std::vector<std::uint32_t> cameras(cloud->size());
  for (std::size_t i = 0; i < cameras.size(); ++i) cameras[i] = static_cast<std::uint32_t>(i / 45000);
  for (const Representatives mode : kAllRepresentatives) {
    AggregationParameters parameters;
    parameters.representatives = mode;
    AdaptiveHashFusion<PointFused> filter(true);
    filter.setParameters(parameters);
    filter.setCameraIndices(cameras);
    filter.setNumberOfThreads(1);
    const auto one = fused(filter, cloud);
    const pcl::Indices removed = *filter.getRemovedIndices();
    ASSERT_GT(one.size(), 1000u);
    for (const unsigned int threads : {2u, 3u, 0u}) {
      filter.setNumberOfThreads(threads);
      EXPECT_TRUE(sameClouds(fused(filter, cloud), one)) << threads << " threads";
      EXPECT_EQ(*filter.getRemovedIndices(), removed);
    }
  }
}

TEST(AdaptiveHashFusion, NamesTheFirstPointThatIsTooFarOutOnAnyNumberOfThreads) {
  const auto cloud = scattered(100000);
  (*cloud)[40000].x = 2e7f;
  (*cloud)[90000].x = 3e7f;
  for (const unsigned int threads : {1u, 2u, 3u}) {
    AdaptiveHashFusion<PointFused> filter;
    filter.setNumberOfThreads(threads);
    expectThrow<pcl::PCLException>([&] { fused(filter, cloud); }, {"(2e+07, "});
  }
}

TEST(AdaptiveHashFusion, CellsAreFixedToTheWorldSoThatPointsFarAwayChangeNothing) {
  const auto cloud = scattered(3000);
  const auto alone = fused<PointFused>(cloud);
  const auto more = std::make_shared<pcl::PointCloud<PointFused>>();
  for (const float far : {-7.123f, 5.017f}) {
    for (int i = 0; i < 50; ++i) {
      more->push_back(distinctPoint<PointFused>(far, far + 0.003f * static_cast<float>(i), -far, 1));
      more->back().confidence = 0.9f;
    }
    if (far < 0) *more += *cloud;
  }
  pcl::PointCloud<PointFused> near;
  for (const PointFused& p : fused<PointFused>(more))
    if (std::fabs(p.x) < 2) near.push_back(p);
  EXPECT_TRUE(sameClouds(near, alone));
}

TEST(AdaptiveHashFusion, PointsInDifferentCellsOnEitherSideOfTheOriginStayApart) {
  const auto cloud = std::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  for (const float x : {-0.001f, 0.001f})
    for (const float y : {-0.001f, 0.001f})
      for (const float z : {-0.001f, 0.001f}) cloud->push_back({x, y, z});
  const auto output = fused<pcl::PointXYZ>(cloud);
  ASSERT_EQ(output.size(), 8u);
  for (const pcl::PointXYZ& p : output) EXPECT_NEAR(p.getVector3fMap().cwiseAbs().minCoeff(), 0.001f, 1e-7f);
}

TEST(AdaptiveHashFusion, CellsFollowTheLocalDensityByHand) {
  // Sixteen points in one coarse cell of 64 mm want 4² = 16 children: side 16 mm, a point in each of the 4 × 4.
  const auto dense = std::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  for (int i = 0; i < 16; ++i)
    dense->push_back(
        {0.008f + 0.016f * static_cast<float>(i % 4), 0.008f + 0.016f * static_cast<float>(i / 4), 0.008f});
  EXPECT_EQ(fused<pcl::PointXYZ>(dense).size(), 16u);
  // Four of them want four children of 32 mm: these four share one.
  const auto sparse = std::make_shared<pcl::PointCloud<pcl::PointXYZ>>(*dense, pcl::Indices{0, 1, 4, 5});
  const auto output = fused<pcl::PointXYZ>(sparse);
  ASSERT_EQ(output.size(), 1u);
  EXPECT_NEAR(output[0].x, 0.016f, 1e-6f);
  EXPECT_NEAR(output[0].y, 0.016f, 1e-6f);
  // No cell is smaller than the smallest.
  AggregationParameters parameters;
  parameters.min_cell_size = 0.064f;
  AdaptiveHashFusion<pcl::PointXYZ> coarse;
  coarse.setParameters(parameters);
  EXPECT_EQ(fused(coarse, dense).size(), 1u);
}

TEST(AdaptiveHashFusion, DropsAPointUnderTheLeastWeight) {
  const auto cloud = std::make_shared<pcl::PointCloud<PointFused>>();
  for (const float C : {0.1f, 0.3f}) {
    cloud->push_back(distinctPoint<PointFused>(C, 0, 0, 1));  // cells apart
    cloud->back().confidence = C;
  }
  AdaptiveHashFusion<PointFused> filter;
  EXPECT_EQ(fused(filter, cloud).size(), 2u);  // weak, but alone
  AggregationParameters parameters;
  parameters.min_weight = 0.2f;
  filter.setParameters(parameters);
  const auto output = fused(filter, cloud);
  ASSERT_EQ(output.size(), 1u);
  EXPECT_NEAR(output[0].x, 0.3f, 1e-6f);
}

TEST(AdaptiveHashFusion, AWeakPointBesideABetterOneGoesUnlessAllAreKept) {
  const auto cloud = std::make_shared<pcl::PointCloud<PointFused>>();
  cloud->push_back(distinctPoint<PointFused>(0.01f, 0.01f, 0.01f, 1));
  cloud->push_back(distinctPoint<PointFused>(0.04f, 0.01f, 0.01f, 1));  // the child of 32 mm beside it
  (*cloud)[0].confidence = 0.9f;
  (*cloud)[1].confidence = 0.1f;
  AdaptiveHashFusion<PointFused> filter;
  const auto output = fused(filter, cloud);
  ASSERT_EQ(output.size(), 1u);
  EXPECT_NEAR(output[0].x, 0.01f, 1e-6f);
  AggregationParameters parameters;
  parameters.weak_weight = 0;
  filter.setParameters(parameters);
  EXPECT_EQ(fused(filter, cloud).size(), 2u);
}

/** \brief Six points of four cameras in one cell that is not refined; x in millimetres is 1, 2, 4, 8, 16, 32. */
class SixPointsOfFourCameras : public ::testing::Test {
 protected:
  SixPointsOfFourCameras() {
    // In mixed order: the camera index identifies a point, not its position.
    add(0.5f, 16, 2);
    add(0.8f, 2, 0);
    add(0.7f, 4, 1);
    add(0.1f, 32, 3);
    add(0.9f, 1, 0);
    add(0.2f, 8, 1);
  }
  void add(float C, float x_mm, std::uint32_t camera) {
    cloud->push_back(distinctPoint<PointFused>(0.001f * x_mm, 0.01f, 0.01f, 1));
    cloud->back().confidence = C;
    cameras.push_back(camera);
  }
  PointFused fusedBy(Representatives mode) {
    AggregationParameters parameters;
    parameters.points_per_cell = 6;
    parameters.representatives = mode;
    filter.setParameters(parameters);
    filter.setCameraIndices(cameras);
    const auto output = fused(filter, cloud);
    EXPECT_EQ(output.size(), 1u);
    return output.empty() ? PointFused() : output[0];
  }

  const pcl::PointCloud<PointFused>::Ptr cloud = std::make_shared<pcl::PointCloud<PointFused>>();
  std::vector<std::uint32_t> cameras;
  AdaptiveHashFusion<PointFused> filter{true};
};

TEST_F(SixPointsOfFourCameras, TheThreeMostConfidentStandForTheCellAsPublished) {
  const PointFused p = fusedBy(Representatives::HighestConfidence);
  EXPECT_NEAR(1000 * p.x, (0.9f * 1 + 0.8f * 2 + 0.7f * 4) / 2.4f, 1e-4f);
  EXPECT_NEAR(p.confidence, (0.81f + 0.64f + 0.49f) / 2.4f, 1e-5f);
  EXPECT_EQ(p.view_count, 2u);
  EXPECT_EQ(*filter.getRemovedIndices(), (pcl::Indices{0, 3, 5}));
}

TEST_F(SixPointsOfFourCameras, TheMostConfidentOfEachCameraStandsForTheCell) {
  const PointFused p = fusedBy(Representatives::DifferentCameras);
  EXPECT_NEAR(1000 * p.x, (0.9f * 1 + 0.7f * 4 + 0.5f * 16) / 2.1f, 1e-4f);
  EXPECT_NEAR(p.confidence, (0.81f + 0.49f + 0.25f) / 2.1f, 1e-5f);
  EXPECT_EQ(p.view_count, 3u);
  EXPECT_EQ(*filter.getRemovedIndices(), (pcl::Indices{1, 3, 5}));
}

TEST_F(SixPointsOfFourCameras, TheMeanOfEachCameraStandsForTheCell) {
  // Cameras weigh 1.7 (two points), 0.9 (two points), 0.5 and 0.1: the last is left out.
  const PointFused p = fusedBy(Representatives::CameraMeans);
  EXPECT_NEAR(1000 * p.x, (0.9f * 1 + 0.8f * 2 + 0.7f * 4 + 0.2f * 8 + 0.5f * 16) / 3.1f, 1e-4f);
  EXPECT_NEAR(p.confidence, (1.7f * 1.7f / 2 + 0.9f * 0.9f / 2 + 0.5f * 0.5f) / 3.1f, 1e-5f);
  EXPECT_EQ(p.view_count, 3u);
}

TEST(AdaptiveHashFusion, IntensityIsDataAsColourIs) {
  const auto cloud = std::make_shared<pcl::PointCloud<pcl::PointXYZI>>();
  std::vector<std::uint32_t>
      cameras;  // the points of one camera are one representative, which has the fields of one of them
  for (int cell = 0; cell < 200; ++cell)
    for (int k = 0; k < 2; ++k) {
      cameras.push_back(static_cast<std::uint32_t>(k));
      pcl::PointXYZI p(static_cast<float>(cell) + 0.001f * static_cast<float>(k), 0.5f, 0.5f);
      p.intensity = static_cast<float>(cell + 2 * k);
      cloud->push_back(p);
    }
  cloud->push_back(pcl::PointXYZI(0.0005f, 0.5f, 0.5f));
  cloud->back().intensity = std::nanf("");  // not known, and left out
  cameras.push_back(2);
  AggregationParameters parameters;
  parameters.cell_size = parameters.min_cell_size = 0.5f;
  AdaptiveHashFusion<pcl::PointXYZI> filter;
  filter.setParameters(parameters);
  filter.setCameraIndices(cameras);
  filter.setInputCloud(cloud);
  pcl::PointCloud<pcl::PointXYZI> output;
  filter.filter(output);
  ASSERT_EQ(output.size(), 200u);
  for (const auto& p : output) EXPECT_NEAR(p.intensity, std::round(p.x) + 1, 1e-4f) << p;
}

TEST(AdaptiveHashFusion, ANormalThatNoPointKnowsStaysAsItIs) {
  const auto cloud = std::make_shared<pcl::PointCloud<pcl::PointNormal>>();
  cloud->push_back(pcl::PointNormal(0, 0, 0, 0, 0, 0));
  cloud->push_back(pcl::PointNormal(1, 0, 0, 0, 0, 2));
  AdaptiveHashFusion<pcl::PointNormal> filter;
  filter.setInputCloud(cloud);
  pcl::PointCloud<pcl::PointNormal> output;
  filter.filter(output);
  ASSERT_EQ(output.size(), 2u);
  EXPECT_TRUE(output.is_dense);
  for (const auto& p : output) EXPECT_EQ(p.normal_z, p.x > 0.5f ? 1.0f : 0.0f);
  (*cloud)[0].normal_x = std::nanf("");
  filter.filter(output);
  EXPECT_FALSE(output.is_dense);
  for (const auto& p : output) EXPECT_EQ(std::isnan(p.normal_x), p.x < 0.5f);
}

TEST(AdaptiveHashFusion, TheMaskHasTheCamerasOfThePoints) {
  const auto cloud = std::make_shared<pcl::PointCloud<fuse_flow::PointFusedCameras>>();
  const std::vector<std::uint32_t> cameras{2, 40, 63, 64, 2};
  for (const std::uint32_t camera : cameras) {
    cloud->emplace_back();
    cloud->back().confidence = 1;
    cloud->back().x = camera == 64 ? 1.0f : 0.0f;
  }
  AdaptiveHashFusion<fuse_flow::PointFusedCameras> filter;
  filter.setInputCloud(cloud);
  filter.setCameraIndices(cameras);
  pcl::PointCloud<fuse_flow::PointFusedCameras> output;
  filter.filter(output);
  ASSERT_EQ(output.size(), 2u);
  for (const auto& p : output) {
    const bool of_64 = p.x > 0.5f;
    EXPECT_EQ(p.view_count, of_64 ? 1u : 3u);
    EXPECT_EQ(fuse_flow::point::getCameraMask(p),
              of_64 ? 0u : std::uint64_t{1} << 2 | std::uint64_t{1} << 40 | std::uint64_t{1} << 63);
  }
}

TEST_F(SixPointsOfFourCameras, WithoutCameraIndicesAllAreOfOneCamera) {
  cameras.clear();
  const PointFused p = fusedBy(Representatives::CameraMeans);
  EXPECT_NEAR(1000 * p.x, (0.9f * 1 + 0.8f * 2 + 0.7f * 4 + 0.2f * 8 + 0.5f * 16 + 0.1f * 32) / 3.2f, 1e-4f);
  EXPECT_EQ(p.view_count, 1u);
}

TEST(AdaptiveHashFusion, WithAFrameCellsAreWeighedWithVOfTheRepresentativesOrOfTheirMean) {
  // Two cameras face a wall at 2 m, each has one point in the cell: the first on the wall, the second 20 mm = σ behind.
  const std::vector<float> wall(41 * 31, 2.0f);
  RigFrame frame;
  for (int i = 0; i < 2; ++i) {
    Camera camera;
    camera.name = "camera";
    camera.intrinsics.width = 41;
    camera.intrinsics.height = 31;
    camera.intrinsics.fx = camera.intrinsics.fy = 40;
    camera.intrinsics.cx = 20;
    camera.intrinsics.cy = 15;
    camera.T_world_camera.translation().x() = 0.2 * i;
    frame.cameras.push_back(camera);
    frame.views.emplace_back();
    frame.views.back().depth32 = {wall.data(), 41, 31};
  }
  const auto cloud = std::make_shared<pcl::PointCloud<pcl::PointXYZI>>();
  for (const float z : {2.0f, 2.02f}) {
    cloud->emplace_back();
    cloud->back().x = cloud->back().y = 0.01f;
    cloud->back().z = z;
  }
  AggregationParameters parameters;
  parameters.points_per_cell = 2;
  AdaptiveHashFusion<pcl::PointXYZI> filter;
  filter.setFrame(frame);
  filter.setCameraIndices({0, 1});
  filter.setWeightInIntensity(true);

  // V is 1 for the first and 1/e for the second.
  parameters.consistency_at = ConsistencyAt::Representatives;
  filter.setParameters(parameters);
  auto output = fused(filter, cloud);
  ASSERT_EQ(output.size(), 1u);
  const float V = std::exp(-1.0f);
  EXPECT_NEAR(output[0].z, (2.0f + V * 2.02f) / (1 + V), 1e-5f);
  EXPECT_NEAR(output[0].intensity, (1 + V * V) / (1 + V), 1e-4f);

  // Their mean is half a σ behind the wall, whichever camera is asked.
  parameters.consistency_at = ConsistencyAt::CellMean;
  filter.setParameters(parameters);
  output = fused(filter, cloud);
  ASSERT_EQ(output.size(), 1u);
  EXPECT_NEAR(output[0].z, 2.01f, 1e-5f);
  EXPECT_NEAR(output[0].intensity, std::exp(-0.25f), 1e-4f);

  // A wall out of range says nothing: V = 1.
  PreprocessingParameters near;
  near.max_range = 1.5f;
  filter.setPreprocessing(near);
  EXPECT_NEAR(fused(filter, cloud)[0].intensity, 1.0f, 1e-6f);
  filter.setPreprocessing({});
  EXPECT_NEAR(fused(filter, cloud)[0].intensity, std::exp(-0.25f), 1e-4f);

  filter.setCameraIndices({0, 2});
  expectThrow([&] { fused(filter, cloud); }, {"AdaptiveHashFusion", "point 1", "camera 2", "has 2"});

  filter.setFrame({});  // no frame any more: V = 1, and cameras have any numbers
  EXPECT_NEAR(fused(filter, cloud)[0].intensity, 1.0f, 1e-6f);
}

TEST(AdaptiveHashFusion, FusesWhatDepthBackprojectionMakesOfAView) {
  const std::vector<float> wall(41 * 31, 2.0f);
  Camera camera = sidewaysCamera();
  camera.intrinsics.width = 41;
  camera.intrinsics.height = 31;
  DepthView view;
  view.depth32 = {wall.data(), 41, 31};
  DepthBackprojection<PointFused> backprojection;
  backprojection.setCamera(camera);
  backprojection.setView(view);
  const auto points = std::make_shared<pcl::PointCloud<PointFused>>();
  backprojection.filter(*points);
  const auto output = fused<PointFused>(points);
  EXPECT_EQ(output.size(), points->size());  // a metre apart
  for (const PointFused& p : output) EXPECT_EQ(p.confidence, 1.0f);
}

TEST(AdaptiveHashFusion, CountsCameraIndicesAndPointsIfTheyDiffer) {
  AdaptiveHashFusion<pcl::PointXYZ> filter;
  filter.setCameraIndices({0, 1, 2});
  expectThrow([&] { fused(filter, planeOf<pcl::PointXYZ>()); },
              {"AdaptiveHashFusion", "3 camera indices", "400 points"});
}

TEST(BadParameters, AdaptiveHashFusionNamesThem) {
  using Filter = AdaptiveHashFusion<pcl::PointXYZ>;
  using P = AggregationParameters;
  const char* owner = "AdaptiveHashFusion";
  expectRejected<Filter>(&P::cell_size, 0.0f, owner, "cell_size", "0");
  expectRejected<Filter>(&P::cell_size, kNaN, owner, "cell_size", "nan");
  expectRejected<Filter>(&P::min_cell_size, -1.0f, owner, "min_cell_size", "-1");
  expectRejected<Filter>(&P::points_per_cell, 0.0f, owner, "points_per_cell", "0");
  expectRejected<Filter>(&P::min_weight, 1.5f, owner, "min_weight", "1.5");
  expectRejected<Filter>(&P::weak_weight, -0.5f, owner, "weak_weight", "-0.5");
  expectRejected<Filter>(&P::confirmation_reach, kNaN, owner, "confirmation_reach", "nan");
  expectRejected<Filter>(&P::reach_per_noise, -1.0f, owner, "reach_per_noise", "-1");
  Filter filter;
  PreprocessingParameters turned;
  turned.max_range = 0.05f;
  expectThrow([&] { filter.setPreprocessing(turned); }, {"max_range is 0.05"});
}

}  // namespace
