#pragma once

/** \file
 *  \brief What the tests of all filters need: points that differ in every field, clouds with header and pose, comparisons bit by bit, parameters
 *  that are refused. */

#include "../conformance_points.h"
#include "../refusal.h"

#include <fuse_flow/camera.h>
#include <fuse_flow/point_traits.h>

#include <pcl/for_each_type.h>
#include <pcl/point_cloud.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

namespace filter_conformance {

using conformance::OddPoint;
using conformance::PointName;
using conformance::pointName;
using conformance::PointTypes;
using refusal::expectThrow;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

template <typename P>
constexpr bool hasConfidence = fuse_flow::point::has_confidence<P>;

template <typename P>
void setConfidence(P& p, float C) {
  if constexpr (hasConfidence<P>) fuse_flow::point::setField<pcl::fields::confidence>(p, C);
}

template <typename P>
float confidenceOf(const P& p) {
  return fuse_flow::point::getField<pcl::fields::confidence, float>(p);
}

template <typename T>
struct Tag {
  using Type = T;
};

/** \brief Calls visit(tag of the field, offset, value) for each field of a point. */
template <typename P, typename Visit>
struct FieldVisitor {
  Visit visit;
  template <typename Field>
  void operator()() const {
    visit(Tag<Field>{}, pcl::traits::offset<P, Field>::value, typename pcl::traits::datatype<P, Field>::type{});
  }
};

template <typename P, typename Visit>
void forEachField(const Visit& visit) {
  pcl::for_each_type<typename pcl::traits::fieldList<P>::type>(FieldVisitor<P, Visit>{visit});
}

template <typename Field>
constexpr bool isPosition = std::is_same_v<Field, pcl::fields::x> || std::is_same_v<Field, pcl::fields::y> ||
                            std::is_same_v<Field, pcl::fields::z>;

/** \brief A point whose every field but the position holds something that tells it from others. */
template <typename P>
P distinctPoint(float x, float y, float z, int number) {
  P p;
  int field_number = 0;
  forEachField<P>([&](auto field, std::size_t offset, auto value) {
    ++field_number;
    if constexpr (!isPosition<typename decltype(field)::Type>) {
      value = static_cast<decltype(value)>(field_number + 10 * number);
      std::memcpy(reinterpret_cast<char*>(&p) + offset, &value, sizeof value);
    }
  });
  p.x = x;
  p.y = y;
  p.z = z;
  setConfidence(p, 0.5f);
  return p;
}

/** \brief Bit by bit, field by field; NaN equals NaN. */
template <typename P>
::testing::AssertionResult sameFields(const P& a, const P& b, bool position = true, bool confidence = true) {
  bool same = true;
  forEachField<P>([&](auto field, std::size_t offset, auto value) {
    using Field = typename decltype(field)::Type;
    if (isPosition<Field> && !position) return;
    if (std::is_same_v<Field, pcl::fields::confidence> && !confidence) return;
    same = same && std::memcmp(reinterpret_cast<const char*>(&a) + offset, reinterpret_cast<const char*>(&b) + offset,
                               sizeof value) == 0;
  });
  if (same) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "the point at (" << a.x << ", " << a.y << ", " << a.z
                                       << ") differs from that at (" << b.x << ", " << b.y << ", " << b.z << ")";
}

template <typename P>
::testing::AssertionResult sameClouds(const pcl::PointCloud<P>& a, const pcl::PointCloud<P>& b) {
  if (a.width != b.width || a.height != b.height || a.size() != b.size())
    return ::testing::AssertionFailure() << a.width << "x" << a.height << " against " << b.width << "x" << b.height;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (auto result = sameFields(a[i], b[i]); !result) return result << ", number " << i;
  return ::testing::AssertionSuccess();
}

template <typename P>
bool finite(const P& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

/** \brief Cloud is marked dense only if it is. */
template <typename P>
void expectHonestDensity(const pcl::PointCloud<P>& cloud) {
  if (cloud.is_dense) {
    EXPECT_TRUE(std::all_of(cloud.begin(), cloud.end(), finite<P>));
  }
}

template <typename P>
void addHeaderAndPose(pcl::PointCloud<P>& cloud) {
  cloud.header.frame_id = "workshop";
  cloud.header.stamp = 1234567;
  cloud.header.seq = 89;
  cloud.sensor_origin_ << 0.5f, -0.25f, 0, 0;
  cloud.sensor_orientation_ = Eigen::Quaternionf(Eigen::AngleAxisf(0.5f, Eigen::Vector3f::UnitZ()));
}

template <typename P>
void expectHeaderAndPose(const pcl::PointCloud<P>& cloud) {
  EXPECT_EQ(cloud.header.frame_id, "workshop");
  EXPECT_EQ(cloud.header.stamp, 1234567u);
  EXPECT_EQ(cloud.header.seq, 89u);
  EXPECT_TRUE(cloud.sensor_origin_.isApprox(Eigen::Vector4f(0.5f, -0.25f, 0, 0)));
  EXPECT_TRUE(
      cloud.sensor_orientation_.isApprox(Eigen::Quaternionf(Eigen::AngleAxisf(0.5f, Eigen::Vector3f::UnitZ()))));
}

/** \brief A 4 × 3 camera at (1, 2, 3) that looks along the world's x axis, its x towards −y and its y towards −z. */
inline fuse_flow::Camera sidewaysCamera() {
  fuse_flow::Camera camera;
  camera.name = "sideways";
  camera.intrinsics.width = 4;
  camera.intrinsics.height = 3;
  camera.intrinsics.fx = camera.intrinsics.fy = 2;
  camera.intrinsics.cx = camera.intrinsics.cy = 1;
  camera.T_world_camera.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  camera.T_world_camera.translation() << 1, 2, 3;
  return camera;
}

template <typename Filter, typename Parameters, typename Value>
void expectRejected(Value Parameters::*member, Value value, const std::string& owner, const std::string& name,
                    const std::string& written) {
  Filter filter;
  Parameters parameters;
  const Value before = parameters.*member;
  parameters.*member = value;
  expectThrow([&] { filter.setParameters(parameters); }, {owner, name + " is " + written});
  EXPECT_EQ(filter.getParameters().*member, before) << "a rejected value was taken over";
}

}  // namespace filter_conformance
