#include "filter_conformance.h"

#include <fuse_flow/filters/depth_backprojection.h>

#include <gtest/gtest.h>

#include <vector>

namespace {

using namespace fuse_flow;
using namespace filter_conformance;

template <typename P>
class DepthBackprojectionOf : public ::testing::Test {};

TYPED_TEST_SUITE(DepthBackprojectionOf, PointTypes, PointName);

// Pixels 1, 4, 6, 8 and 9 hold no measurement: none, not a number, infinite, nearer than 0.1 m, farther than 20 m.
const std::vector<float> kDepth{1, 0, 1, 2, kNaN, 4, kInf, 1, 0.05f, 21, 2, 2};
const pcl::Indices kNoDepth{1, 4, 6, 8, 9};

template <typename P>
typename pcl::PointCloud<P>::Ptr depthCloud() {
  auto cloud = std::make_shared<pcl::PointCloud<P>>(4, 3);
  for (std::size_t i = 0; i < 12; ++i) (*cloud)[i] = distinctPoint<P>(0, 0, kDepth[i], static_cast<int>(i));
  cloud->is_dense = false;
  addHeaderAndPose(*cloud);
  return cloud;
}

DepthView depthView() {
  DepthView view;
  view.depth32 = {kDepth.data(), 4, 3};
  return view;
}

template <typename P>
void expectBackprojectedByHand(const pcl::PointCloud<P>& cloud) {
  ASSERT_EQ(cloud.width, 4u);
  ASSERT_EQ(cloud.height, 3u);
  for (int i = 0; i < 12; ++i) {
    const P& p = cloud[static_cast<std::size_t>(i)];
    if (std::find(kNoDepth.begin(), kNoDepth.end(), i) != kNoDepth.end()) {
      EXPECT_TRUE(std::isnan(p.x) && std::isnan(p.y) && std::isnan(p.z)) << "pixel " << i;
      continue;
    }
    const float z = kDepth[static_cast<std::size_t>(i)];
    EXPECT_EQ(p.x, 1 + z) << "pixel " << i;
    EXPECT_EQ(p.y, 2 - z * static_cast<float>(i % 4 - 1) / 2) << "pixel " << i;
    EXPECT_EQ(p.z, 3 - z * static_cast<float>(i / 4 - 1) / 2) << "pixel " << i;
  }
}

TYPED_TEST(DepthBackprojectionOf, PutsEveryPixelOfACloudWhereHandCalculationDoes) {
  const auto cloud = depthCloud<TypeParam>();
  DepthBackprojection<TypeParam> filter(true);
  filter.setCamera(sidewaysCamera());
  filter.setInputCloud(cloud);
  pcl::PointCloud<TypeParam> output;
  filter.filter(output);
  expectBackprojectedByHand(output);
  // Pixel (3, 0), depth 2: ray (1, −½), camera (2, −1, 2), world (1 + 2, 2 − 2, 3 + 1).
  EXPECT_EQ(output.at(3, 0).x, 3.0f);
  EXPECT_EQ(output.at(3, 0).y, 0.0f);
  EXPECT_EQ(output.at(3, 0).z, 4.0f);
  EXPECT_EQ(*filter.getRemovedIndices(), kNoDepth);
  EXPECT_FALSE(output.is_dense);
  for (std::size_t i = 0; i < 12; ++i) {
    TypeParam carried = (*cloud)[i];
    const Vec3 n = point::getNormal(carried);
    point::setNormal(carried, {n.z, -n.x, -n.y});  // in the world, as the camera's axes are
    EXPECT_TRUE(sameFields(output[i], carried, false)) << "pixel " << i;
  }
}

TYPED_TEST(DepthBackprojectionOf, OfAViewAgreesWithThatOfACloud) {
  DepthBackprojection<TypeParam> filter(true);
  filter.setCamera(sidewaysCamera());
  filter.setView(depthView());
  pcl::PointCloud<TypeParam> output;
  filter.filter(output);
  expectBackprojectedByHand(output);
  EXPECT_EQ(*filter.getRemovedIndices(), kNoDepth);
  EXPECT_FALSE(output.is_dense);
}

TYPED_TEST(DepthBackprojectionOf, GivesTheCamerasPoseAndTheCloudsHeader) {
  DepthBackprojection<TypeParam> filter;
  filter.setCamera(sidewaysCamera());
  filter.setInputCloud(depthCloud<TypeParam>());
  pcl::PointCloud<TypeParam> output;
  filter.filter(output);
  EXPECT_TRUE(output.sensor_origin_.isApprox(Eigen::Vector4f(1, 2, 3, 0)));
  EXPECT_TRUE((output.sensor_orientation_ * Eigen::Vector3f::UnitZ()).isApprox(Eigen::Vector3f::UnitX()));
  EXPECT_TRUE((output.sensor_orientation_ * Eigen::Vector3f::UnitX()).isApprox(-Eigen::Vector3f::UnitY()));
  EXPECT_EQ(output.header.frame_id, "workshop");
  EXPECT_EQ(output.header.stamp, 1234567u);
}

TYPED_TEST(DepthBackprojectionOf, RestrictsItselfToTheIndices) {
  for (const bool from_view : {false, true}) {
    DepthBackprojection<TypeParam> filter(true);
    filter.setCamera(sidewaysCamera());
    if (from_view) {
      filter.setView(depthView());
    } else {
      filter.setInputCloud(depthCloud<TypeParam>());
    }
    filter.setIndices(std::make_shared<pcl::Indices>(pcl::Indices{7, 3, 4}));
    pcl::PointCloud<TypeParam> output;
    filter.filter(output);
    ASSERT_EQ(output.width, 4u);
    ASSERT_EQ(output.height, 3u);
    for (int i = 0; i < 12; ++i)
      EXPECT_EQ(finite(output[static_cast<std::size_t>(i)]), i == 3 || i == 7) << "pixel " << i;
    EXPECT_EQ(*filter.getRemovedIndices(), pcl::Indices{4});  // of the indices, the one without a measurement
    EXPECT_FALSE(output.is_dense);
  }
}

TYPED_TEST(DepthBackprojectionOf, RestrictsItselfToABlockOfPixels) {
  for (const bool from_view : {false, true}) {
    DepthBackprojection<TypeParam> filter;
    filter.setCamera(sidewaysCamera());
    if (from_view) {
      filter.setView(depthView());
    } else {
      filter.setInputCloud(depthCloud<TypeParam>());
    }
    filter.setIndices(1, 1, 2, 3);  // from row 1, column 1 on, two rows of three columns
    pcl::PointCloud<TypeParam> output;
    filter.filter(output);
    ASSERT_EQ(output.size(), 12u);
    for (int i = 0; i < 12; ++i) {
      const bool inside = i / 4 >= 1 && i % 4 >= 1;
      const bool measured = std::find(kNoDepth.begin(), kNoDepth.end(), i) == kNoDepth.end();
      EXPECT_EQ(finite(output[static_cast<std::size_t>(i)]), inside && measured) << "pixel " << i;
    }
  }
}

TYPED_TEST(DepthBackprojectionOf, WritesTheUserFilterValueWhereThereIsNoDepth) {
  DepthBackprojection<TypeParam> filter;
  filter.setCamera(sidewaysCamera());
  filter.setInputCloud(depthCloud<TypeParam>());
  filter.setUserFilterValue(-5.0f);
  pcl::PointCloud<TypeParam> output;
  filter.filter(output);
  for (const pcl::index_t i : kNoDepth) {
    EXPECT_EQ(output[static_cast<std::size_t>(i)].x, -5.0f);
    EXPECT_EQ(output[static_cast<std::size_t>(i)].z, -5.0f);
  }
  EXPECT_TRUE(output.is_dense);
}

TYPED_TEST(DepthBackprojectionOf, FiltersInPlace) {
  const auto cloud = depthCloud<TypeParam>();
  DepthBackprojection<TypeParam> filter;
  filter.setCamera(sidewaysCamera());
  filter.setInputCloud(cloud);
  pcl::PointCloud<TypeParam> elsewhere;
  filter.filter(elsewhere);
  filter.filter(*cloud);
  EXPECT_TRUE(sameClouds(*cloud, elsewhere));
}

TYPED_TEST(DepthBackprojectionOf, ColoursThePointsOfAViewThatHasColour) {
  if constexpr (!point::has_color<TypeParam>) {
    GTEST_SKIP() << "no colour field";
  } else {
    std::vector<Rgb8> colors(12);
    for (std::uint8_t i = 0; i < 12; ++i) colors[i] = {i, static_cast<std::uint8_t>(100 + i), 255};
    DepthView view = depthView();
    view.color = {colors.data(), 4, 3};
    DepthBackprojection<TypeParam> filter;
    filter.setCamera(sidewaysCamera());
    filter.setView(view);
    pcl::PointCloud<TypeParam> output;
    filter.filter(output);
    for (const std::size_t i : {0u, 3u, 5u, 11u}) {
      EXPECT_EQ(output[i].r, i);
      EXPECT_EQ(output[i].g, 100 + i);
      EXPECT_EQ(output[i].b, 255);
      EXPECT_EQ(output[i].a, 255);
    }
  }
}

TYPED_TEST(DepthBackprojectionOf, GivesThePointsOfAViewItsConfidenceOrOne) {
  if constexpr (!hasConfidence<TypeParam>) {
    GTEST_SKIP() << "no confidence field";
  } else {
    DepthBackprojection<TypeParam> filter;
    filter.setCamera(sidewaysCamera());
    filter.setView(depthView());
    pcl::PointCloud<TypeParam> output;
    filter.filter(output);
    for (const std::size_t i : {0u, 2u, 3u, 5u}) EXPECT_EQ(confidenceOf(output[i]), 1.0f) << "pixel " << i;
    const std::vector<float> given{0.25f, 1, 0, kNaN, 1, 3, 1, 1, 1, 1, 1, 1};
    DepthView view = depthView();
    view.confidence = {given.data(), 4, 3};
    filter.setView(view);
    filter.filter(output);
    EXPECT_EQ(confidenceOf(output[0]), 0.25f);
    EXPECT_EQ(confidenceOf(output[2]), 0.0f);
    EXPECT_EQ(confidenceOf(output[3]), 0.0f);  // not a number is no confidence
    EXPECT_EQ(confidenceOf(output[5]), 1.0f);
  }
}

TEST(DepthBackprojection, SixteenBitDepthHasAScaleAndTwoNumbersThatMeanNothing) {
  const std::vector<std::uint16_t> raw{1000, 0, 500, 65535, 250, 1000, 1000, 1000, 1000, 1000, 1000, 4000};
  DepthView view;
  view.depth16 = {raw.data(), 4, 3};
  DepthBackprojection<pcl::PointXYZ> filter(true);
  Camera camera = sidewaysCamera();
  camera.depth_scale = 0.002f;
  camera.T_world_camera.setIdentity();
  filter.setCamera(camera);
  filter.setView(view);
  PreprocessingParameters far;
  far.max_range = 200;  // 65535 would be 131 m
  filter.setParameters(far);
  pcl::PointCloud<pcl::PointXYZ> output;
  filter.filter(output);
  EXPECT_EQ(*filter.getRemovedIndices(), (pcl::Indices{1, 3}));
  EXPECT_FLOAT_EQ(output[0].z, 2.0f);
  EXPECT_FLOAT_EQ(output[4].z, 0.5f);
  EXPECT_FLOAT_EQ(output[11].x, 8.0f);  // pixel (3, 2): ray (1, ½), depth 8
  EXPECT_FLOAT_EQ(output[11].y, 4.0f);
}

TEST(DepthBackprojection, TheLastInputSetIsTheOneUsed) {
  const std::vector<float> other(12, 5.0f);
  DepthView view;
  view.depth32 = {other.data(), 4, 3};
  DepthBackprojection<pcl::PointXYZ> filter;
  filter.setCamera(sidewaysCamera());
  pcl::PointCloud<pcl::PointXYZ> output;
  filter.setView(view);
  filter.filter(output);
  EXPECT_EQ(output[0].x, 6.0f);
  filter.setInputCloud(depthCloud<pcl::PointXYZ>());
  filter.filter(output);
  expectBackprojectedByHand(output);
  filter.setView(view);
  filter.filter(output);
  EXPECT_EQ(output[0].x, 6.0f);
}

TEST(DepthBackprojection, NamesTheCameraIfTheInputDoesNotHaveItsSize) {
  DepthBackprojection<pcl::PointXYZ> filter;
  filter.setCamera(sidewaysCamera());
  pcl::PointCloud<pcl::PointXYZ> output;
  filter.setInputCloud(std::make_shared<pcl::PointCloud<pcl::PointXYZ>>(5, 2));
  expectThrow([&] { filter.filter(output); }, {"DepthBackprojection", "5x2", "'sideways'", "4x3"});
  filter.setInputCloud(std::make_shared<pcl::PointCloud<pcl::PointXYZ>>());
  expectThrow([&] { filter.filter(output); }, {"DepthBackprojection", "0x", "'sideways'", "4x3"});
  DepthView view;
  view.depth32 = {kDepth.data(), 3, 4};
  filter.setView(view);
  expectThrow([&] { filter.filter(output); }, {"'sideways'", "3x4", "4x3"});
}

TEST(BadParameters, DepthBackprojectionNamesThem) {
  using Filter = DepthBackprojection<pcl::PointXYZ>;
  using P = PreprocessingParameters;
  const char* owner = "DepthBackprojection";
  expectRejected<Filter>(&P::min_range, -1.0f, owner, "min_range", "-1");
  expectRejected<Filter>(&P::max_range, kInf, owner, "max_range", "inf");
  expectRejected<Filter>(&P::max_range, 0.05f, owner, "max_range", "0.05");
  expectRejected<Filter>(&P::fill_neighbours, 2, owner, "fill_neighbours", "2");
  expectRejected<Filter>(&P::fill_neighbours, 9, owner, "fill_neighbours", "9");
  expectRejected<Filter>(&P::fill_tolerance, 0.0f, owner, "fill_tolerance", "0");
  expectRejected<Filter>(&P::bilateral_sigma_s, 0.0f, owner, "bilateral_sigma_s", "0");
  expectRejected<Filter>(&P::bilateral_sigma_r, kNaN, owner, "bilateral_sigma_r", "nan");
  Filter filter;
  Camera camera = sidewaysCamera();
  camera.intrinsics.fx = 0;
  expectThrow([&] { filter.setCamera(camera); }, {"'sideways'", "fx is 0"});
}

}  // namespace
