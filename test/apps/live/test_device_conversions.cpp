#include "live/device_conversions.h"

#include <fuse_flow/camera.h>

#include <gtest/gtest.h>

namespace {

using namespace fuse_flow;

TEST(DeviceConversions, RowsAreCopiedWithoutWhatFollowsThem) {
  const std::uint16_t rows[] = {1, 2, 3, 99, 4, 5, 6, 99};
  io::DepthImage depth;
  io::copyRows(rows, 4 * sizeof(std::uint16_t), 3, 2, depth);
  EXPECT_EQ(depth.width, 3);
  EXPECT_EQ(depth.height, 2);
  EXPECT_EQ(depth.data, (std::vector<std::uint16_t>{1, 2, 3, 4, 5, 6}));
}

TEST(DeviceConversions, BytesOfColourKeepTheirOrder) {
  const std::uint8_t rows[] = {10, 20, 30, 40, 50, 60};
  io::ColorImage color;
  io::copyRows(rows, 3, 1, 2, color);
  EXPECT_EQ(color.at(0, 0).r, 10);
  EXPECT_EQ(color.at(0, 0).g, 20);
  EXPECT_EQ(color.at(0, 0).b, 30);
  EXPECT_EQ(color.at(0, 1).r, 40);
}

TEST(DeviceConversions, TheAxisOfACentredLensGoesThroughTheMiddleOfTheImage) {
  const Intrinsics lens = io::centredLens(640, 480, 570.0f);
  EXPECT_EQ(lens.width, 640);
  EXPECT_EQ(lens.height, 480);
  EXPECT_EQ(lens.fx, 570.0f);
  EXPECT_EQ(lens.fy, 570.0f);
  EXPECT_EQ(lens.cx, 319.5f);
  EXPECT_EQ(lens.cy, 239.5f);
}

TEST(DeviceConversions, ARotationIsReadColumnByColumn) {
  // A quarter turn about z takes x to y: its first column is y.
  const float rotation[9] = {0, 1, 0, -1, 0, 0, 0, 0, 1};
  const float translation[3] = {0.015f, 0, 0.5f};
  const Eigen::Isometry3d pose = io::columnMajorPose(rotation, translation);
  EXPECT_TRUE((pose * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d(0.015f, 1, 0.5), 1e-9));
}

TEST(DeviceConversions, APoseOfFloatsBecomesRigid) {
  const float rotation[9] = {0.99999f, 0.0045f, 0, -0.0045f, 0.99999f, 0, 0, 0, 1.00001f};
  const float translation[3] = {0, 0, 0};
  const Eigen::Matrix3d R = io::columnMajorPose(rotation, translation).linear();
  EXPECT_TRUE((R * R.transpose()).isApprox(Eigen::Matrix3d::Identity(), 1e-12));
}

TEST(DeviceConversions, ARotationIsReadRowByRowAndMillimetresBecomeMetres) {
  // A quarter turn about z takes x to y: its first column is y.
  const float rotation[9] = {0, -1, 0, 1, 0, 0, 0, 0, 1};
  const float translation[3] = {-32, 2, 4};
  const Eigen::Isometry3d pose = io::rowMajorPose(rotation, translation);
  EXPECT_TRUE((pose * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d(-0.032, 1.002, 0.004), 1e-6));
}

TEST(DeviceConversions, DepthInAnotherUnitIsRoundedAndHolesStayHoles) {
  io::DepthImage depth;
  depth.resize(4, 1);
  depth.data = {0, 10, 14, 15};
  io::rescaleDepth(depth, 0.1f);
  EXPECT_EQ(depth.data, (std::vector<std::uint16_t>{0, 1, 1, 2}));
}

TEST(DeviceConversions, DepthThatDoesNotFitInAnotherUnitIsAHole) {
  io::DepthImage depth;
  depth.resize(3, 1);
  depth.data = {6553, 6554, 65535};
  io::rescaleDepth(depth, 10);
  EXPECT_EQ(depth.data, (std::vector<std::uint16_t>{65530, 0, 0}));
}

constexpr std::uint64_t kCounterPeriod = std::uint64_t{1} << 32;

TEST(DeviceConversions, ACounterThatBeginsAgainGoesOn) {
  io::UnwrappedStamp unwrapped;
  EXPECT_EQ(unwrapped(kCounterPeriod - 10), kCounterPeriod - 10);
  EXPECT_EQ(unwrapped(33'000), kCounterPeriod + 33'000);
  EXPECT_EQ(unwrapped(66'000), kCounterPeriod + 66'000);
  EXPECT_EQ(unwrapped(kCounterPeriod - 1), 2 * kCounterPeriod - 1);
  EXPECT_EQ(unwrapped(0), 2 * kCounterPeriod);
}

TEST(DeviceConversions, StampsOfACameraThatWasStartedAgainGoBack) {
  io::UnwrappedStamp unwrapped;
  EXPECT_EQ(unwrapped(1'000'000'000), 1'000'000'000u);
  EXPECT_EQ(unwrapped(5'000), 5'000u);
}

TEST(DeviceConversions, ACounterWithMoreThan32BitsIsLeftAlone) {
  io::UnwrappedStamp unwrapped;
  EXPECT_EQ(unwrapped(3 * kCounterPeriod), 3 * kCounterPeriod);
  EXPECT_EQ(unwrapped(100), 100u);
}

}  // namespace
