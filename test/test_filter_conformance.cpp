#include "conformance_points.h"

#include <fuse_flow/adaptive_hash_fusion.h>
#include <fuse_flow/confidence_estimation.h>
#include <fuse_flow/depth_backprojection.h>
#include <fuse_flow/multi_view_consistency.h>

#include <pcl/for_each_type.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <numeric>
#include <random>
#include <set>
#include <type_traits>

namespace {

using namespace fuse_flow;
using conformance::OddPoint;
using conformance::PointName;
using conformance::pointName;
using conformance::PointTypes;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

template <typename P>
constexpr bool hasConfidence = point::has<P, pcl::fields::confidence>;

template <typename P>
void setConfidence(P& p, float C) {
  if constexpr (hasConfidence<P>) point::setField<pcl::fields::confidence>(p, C);
}

template <typename P>
float confidenceOf(const P& p) {
  return point::getField<pcl::fields::confidence, float>(p);
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

template <typename Exception = pcl::BadArgumentException>
void expectThrow(const std::function<void()>& action, const std::vector<std::string>& words) {
  try {
    action();
    FAIL() << "nothing was thrown, expected a complaint about " << words.back();
  } catch (const Exception& e) {
    for (const std::string& word : words)
      EXPECT_NE(std::string(e.what()).find(word), std::string::npos) << word << " not in: " << e.what();
  }
}

// ---------------------------------------------------------------------------------------------------------------------------
// Filters that choose points.

constexpr int kWidth = 12, kHeight = 9;
constexpr pcl::index_t kSpike = 3 * kWidth + 4;  // half way between sensor and wall
const pcl::Indices kNotFinite{0, 6 * kWidth + 9, 8 * kWidth + 11};

pcl::Indices sorted(pcl::Indices indices) {
  std::sort(indices.begin(), indices.end());
  return indices;
}

pcl::Indices allBut(const pcl::Indices& removed) {
  pcl::Indices kept;
  for (pcl::index_t i = 0; i < kWidth * kHeight; ++i)
    if (std::find(removed.begin(), removed.end(), i) == removed.end()) kept.push_back(i);
  return kept;
}

pcl::Indices both(pcl::Indices a, const pcl::Indices& b) {
  a.insert(a.end(), b.begin(), b.end());
  return sorted(a);
}

pcl::Indices intersection(const pcl::Indices& a, const pcl::Indices& b) {
  pcl::Indices result;
  for (const pcl::index_t i : a)
    if (std::find(b.begin(), b.end(), i) != b.end()) result.push_back(i);
  return result;
}

/** \brief A wall at 1 m with a point half way to it, which is wrong, and three points that are not finite. */
template <typename P>
typename pcl::PointCloud<P>::Ptr wallWithSpike() {
  auto cloud = std::make_shared<pcl::PointCloud<P>>(kWidth, kHeight);
  for (int i = 0; i < kWidth * kHeight; ++i)
    (*cloud)[static_cast<std::size_t>(i)] = distinctPoint<P>(0.01f * static_cast<float>(i % kWidth - 6),
                                                             0.01f * static_cast<float>(i / kWidth - 4), 1.0f, i);
  (*cloud)[kSpike].z = 0.5f;
  (*cloud)[static_cast<std::size_t>(kNotFinite[0])].z = kNaN;
  (*cloud)[static_cast<std::size_t>(kNotFinite[1])].x = kInf;
  (*cloud)[static_cast<std::size_t>(kNotFinite[2])].y = -kInf;
  cloud->is_dense = false;
  addHeaderAndPose(*cloud);
  return cloud;
}

template <typename P>
struct ConfidenceCase {
  using Point = P;
  using Filter = ConfidenceEstimation<P>;
  static constexpr const char* name = "ConfidenceEstimation";
  /** \brief A threshold that pixels beside a hole pass. */
  static void configure(Filter& filter) {
    ConfidenceParameters parameters;
    parameters.threshold = 0.4f;
    filter.setParameters(parameters);
  }
  /** \brief The spike, and the eight pixels beside it that see a jump of half a metre. */
  static pcl::Indices bad() {
    pcl::Indices indices;
    for (int dv = -1; dv <= 1; ++dv)
      for (int du = -1; du <= 1; ++du) indices.push_back(kSpike + dv * kWidth + du);
    return indices;
  }
};

template <typename P>
struct ConsistencyCase {
  using Point = P;
  using Filter = MultiViewConsistency<P>;
  static constexpr const char* name = "MultiViewConsistency";
  static void configure(Filter& filter) {
    static const std::vector<float> wall(64 * 48, 1.0f);
    RigFrame frame;
    for (int i = 0; i < 2; ++i) {
      Camera camera;
      camera.name = "camera";
      camera.intrinsics.width = 64;
      camera.intrinsics.height = 48;
      camera.intrinsics.fx = camera.intrinsics.fy = 50;
      camera.intrinsics.cx = 32;
      camera.intrinsics.cy = 24;
      camera.T_world_camera.translation().x() = 0.1 * i;
      frame.cameras.push_back(camera);
      frame.views.emplace_back();
      frame.views.back().depth32 = {wall.data(), 64, 48};
    }
    filter.setFrame(frame, 0);
  }
  /** \brief The spike alone: the other camera has seen through it. */
  static pcl::Indices bad() { return {kSpike}; }
};

template <typename Case>
class IndexFilterConformance : public ::testing::Test {
 protected:
  using Point = typename Case::Point;
  using Filter = typename Case::Filter;
  using Cloud = pcl::PointCloud<Point>;

  IndexFilterConformance() {
    Case::configure(filter);
    filter.setInputCloud(cloud);
  }

  const pcl::Indices bad = sorted(Case::bad());
  const pcl::Indices good = allBut(both(bad, kNotFinite));
  typename Cloud::Ptr cloud = wallWithSpike<Point>();
  Filter filter{true};
};

template <typename Types>
struct CasesOf;

template <typename... P>
struct CasesOf<::testing::Types<P...>> {
  using Type = ::testing::Types<ConfidenceCase<P>..., ConsistencyCase<P>...>;
};

using IndexFilterCases = CasesOf<PointTypes>::Type;

struct CaseName {
  template <typename Case>
  static std::string GetName(int) {
    return Case::name + ("Of" + pointName<typename Case::Point>());
  }
};

TYPED_TEST_SUITE(IndexFilterConformance, IndexFilterCases, CaseName);

TYPED_TEST(IndexFilterConformance, KeepsTheGoodPointsInOrder) {
  pcl::Indices kept;
  this->filter.filter(kept);
  EXPECT_EQ(kept, this->good);
}

TYPED_TEST(IndexFilterConformance, NegativeKeepsTheBadPointsButNeverOnesThatAreNotFinite) {
  pcl::Indices kept;
  this->filter.setNegative(true);
  this->filter.filter(kept);
  EXPECT_EQ(kept, this->bad);
}

TYPED_TEST(IndexFilterConformance, HonoursIndicesAndTheirOrder) {
  const auto indices = std::make_shared<pcl::Indices>();
  for (pcl::index_t i = kWidth * kHeight - 1; i >= 0; i -= 2) indices->push_back(i);
  indices->push_back(kSpike);
  this->filter.setIndices(indices);
  const pcl::Indices given = *indices;
  pcl::Indices kept;
  this->filter.filter(kept);
  EXPECT_EQ(kept, intersection(given, this->good));
  this->filter.setNegative(true);
  this->filter.filter(kept);
  EXPECT_EQ(kept, intersection(given, this->bad));
  EXPECT_EQ(*indices, given);
}

TYPED_TEST(IndexFilterConformance, RemovedIndicesAreAllOthersOfTheIndices) {
  pcl::Indices kept;
  this->filter.filter(kept);
  EXPECT_EQ(sorted(*this->filter.getRemovedIndices()), both(this->bad, kNotFinite));
  this->filter.setNegative(true);
  this->filter.filter(kept);
  EXPECT_EQ(sorted(*this->filter.getRemovedIndices()), both(this->good, kNotFinite));
  this->filter.setNegative(false);
  this->filter.setIndices(std::make_shared<pcl::Indices>(pcl::Indices{1, kSpike, kNotFinite[1]}));
  this->filter.filter(kept);
  EXPECT_EQ(kept, pcl::Indices{1});
  EXPECT_EQ(sorted(*this->filter.getRemovedIndices()), sorted({kSpike, kNotFinite[1]}));
}

TYPED_TEST(IndexFilterConformance, WithoutBeingAskedForItExtractsNoRemovedIndices) {
  typename TestFixture::Filter plain;
  TypeParam::configure(plain);
  plain.setInputCloud(this->cloud);
  pcl::Indices kept;
  plain.filter(kept);
  EXPECT_EQ(kept, this->good);
  EXPECT_TRUE(plain.getRemovedIndices()->empty());
}

TYPED_TEST(IndexFilterConformance, TheFilteredCloudIsThatOfTheFilteredIndices) {
  for (const bool negative : {false, true}) {
    this->filter.setNegative(negative);
    pcl::Indices kept;
    this->filter.filter(kept);
    typename TestFixture::Cloud output;
    this->filter.filter(output);
    ASSERT_EQ(output.size(), kept.size());
    EXPECT_EQ(output.width, kept.size());
    EXPECT_EQ(output.height, 1u);
    for (std::size_t i = 0; i < kept.size(); ++i)
      EXPECT_TRUE(sameFields(output[i], (*this->cloud)[static_cast<std::size_t>(kept[i])], true, false));
  }
}

TYPED_TEST(IndexFilterConformance, TheFilteredCloudHoldsNoPointThatIsNotFinite) {
  for (const bool negative : {false, true}) {
    this->filter.setNegative(negative);
    typename TestFixture::Cloud output;
    this->filter.filter(output);
    EXPECT_TRUE(std::all_of(output.begin(), output.end(), finite<typename TestFixture::Point>));
  }
}

TYPED_TEST(IndexFilterConformance, ADenseCloudStaysDense) {
  for (const pcl::index_t i : kNotFinite) {
    auto& point = (*this->cloud)[static_cast<std::size_t>(i)];
    point.x = point.y = 0;
    point.z = 1;
  }
  this->cloud->is_dense = true;
  typename TestFixture::Cloud output;
  this->filter.filter(output);
  EXPECT_TRUE(output.is_dense);
  this->filter.setKeepOrganized(true);
  this->filter.setUserFilterValue(7.0f);
  this->filter.filter(output);
  EXPECT_TRUE(output.is_dense);
  this->filter.setUserFilterValue(kNaN);
  this->filter.filter(output);
  EXPECT_FALSE(output.is_dense);
}

TYPED_TEST(IndexFilterConformance, CarriesHeaderAndSensorPoseOver) {
  typename TestFixture::Cloud output;
  this->filter.filter(output);
  expectHeaderAndPose(output);
  this->filter.setKeepOrganized(true);
  this->filter.filter(output);
  expectHeaderAndPose(output);
}

TYPED_TEST(IndexFilterConformance, KeptOrganizedReplacesOnlyThePositionsOfRemovedPoints) {
  for (const bool negative : {false, true})
    for (const float value : {kNaN, 7.0f}) {
      this->filter.setNegative(negative);
      this->filter.setKeepOrganized(true);
      this->filter.setUserFilterValue(value);
      typename TestFixture::Cloud output;
      this->filter.filter(output);
      ASSERT_EQ(output.width, static_cast<std::uint32_t>(kWidth));
      ASSERT_EQ(output.height, static_cast<std::uint32_t>(kHeight));
      const pcl::Indices& kept = negative ? this->bad : this->good;
      for (pcl::index_t i = 0; i < kWidth * kHeight; ++i) {
        const auto& out = output[static_cast<std::size_t>(i)];
        const auto& in = (*this->cloud)[static_cast<std::size_t>(i)];
        const bool stays = std::find(kept.begin(), kept.end(), i) != kept.end();
        EXPECT_TRUE(sameFields(out, in, stays, false)) << "point " << i;
        if (stays) continue;
        for (const float coordinate : {out.x, out.y, out.z})
          EXPECT_TRUE(std::isnan(value) ? std::isnan(coordinate) : coordinate == value) << "point " << i;
      }
      expectHonestDensity(output);
    }
}

TYPED_TEST(IndexFilterConformance, FiltersInPlace) {
  for (const bool organized : {false, true}) {
    typename TestFixture::Filter fresh(true);
    TypeParam::configure(fresh);
    const auto scene = wallWithSpike<typename TestFixture::Point>();
    fresh.setInputCloud(scene);
    fresh.setKeepOrganized(organized);
    typename TestFixture::Cloud elsewhere;
    fresh.filter(elsewhere);
    fresh.filter(*scene);
    EXPECT_TRUE(sameClouds(*scene, elsewhere));
    expectHeaderAndPose(*scene);
  }
}

TYPED_TEST(IndexFilterConformance, AnEmptyCloudGivesAnEmptyCloud) {
  this->filter.setInputCloud(std::make_shared<typename TestFixture::Cloud>());
  typename TestFixture::Cloud output = *this->cloud;
  ASSERT_NO_THROW(this->filter.filter(output));
  EXPECT_TRUE(output.empty());
  EXPECT_EQ(output.width, 0u);
  pcl::Indices kept{1, 2};
  ASSERT_NO_THROW(this->filter.filter(kept));
  EXPECT_TRUE(kept.empty());
  EXPECT_TRUE(this->filter.getRemovedIndices()->empty());
}

TYPED_TEST(IndexFilterConformance, TheSameOnAnyNumberOfThreads) {
  typename TestFixture::Cloud one, three;
  this->filter.setNumberOfThreads(1);
  this->filter.filter(one);
  this->filter.setNumberOfThreads(3);
  this->filter.filter(three);
  EXPECT_TRUE(sameClouds(one, three));
}

TYPED_TEST(IndexFilterConformance, ConfidenceGoesWithItsPointEvenIfAllPointsAreGivenInAnotherOrder) {
  using P = typename TestFixture::Point;
  if constexpr (!hasConfidence<P>) {
    GTEST_SKIP() << "no confidence field";
  } else {
    // Nothing is removed, so that PCL's copy takes its short cut, which ignores the order of the indices.
    for (std::size_t i = 0; i < this->cloud->size(); ++i) {
      P& p = (*this->cloud)[i];
      if (!finite(p)) p = distinctPoint<P>(0, 0, 1, static_cast<int>(i));
      p.z = 1;
      setConfidence(p, 0.001f * static_cast<float>(i + 1));
    }
    (*this->cloud)[15].z = 1.005f;  // less good than the rest, but good enough
    typename TestFixture::Cloud straight, reversed;
    this->filter.filter(straight);
    ASSERT_EQ(straight.size(), this->cloud->size());
    const auto indices = std::make_shared<pcl::Indices>(this->cloud->size());
    std::iota(indices->rbegin(), indices->rend(), 0);
    this->filter.setIndices(indices);
    this->filter.filter(reversed);
    ASSERT_EQ(reversed.size(), straight.size());
    const auto sameAs = [](const P& a) { return [&a](const P& b) { return bool(sameFields(a, b)); }; };
    for (const P& p : reversed) EXPECT_TRUE(std::any_of(straight.begin(), straight.end(), sameAs(p)));
  }
}

template <typename P>
class PointConformance : public ::testing::Test {};

TYPED_TEST_SUITE(PointConformance, PointTypes, PointName);

TYPED_TEST(PointConformance, ConfidenceEstimationWritesCToTheConfidenceField) {
  const auto cloud = wallWithSpike<TypeParam>();
  ConfidenceEstimation<TypeParam> filter(true);
  filter.setInputCloud(cloud);
  pcl::PointCloud<TypeParam> output;
  pcl::Indices kept;
  filter.filter(kept);
  filter.filter(output);
  const std::vector<float>& C = filter.getConfidence();
  ASSERT_EQ(C.size(), cloud->size());
  EXPECT_FLOAT_EQ(C[4 * kWidth + 8 - 2 * kWidth], 1.0f);  // wall all around
  for (const pcl::index_t i : kNotFinite) EXPECT_EQ(C[static_cast<std::size_t>(i)], 0.0f);
  EXPECT_GT(C[kSpike], 0.0f);
  if constexpr (hasConfidence<TypeParam>) {
    ASSERT_EQ(output.size(), kept.size());
    for (std::size_t i = 0; i < kept.size(); ++i)
      EXPECT_EQ(confidenceOf(output[i]), C[static_cast<std::size_t>(kept[i])]);
    filter.setKeepOrganized(true);
    filter.filter(output);
    for (std::size_t i = 0; i < C.size(); ++i) EXPECT_EQ(confidenceOf(output[i]), C[i]);
  }
}

TYPED_TEST(PointConformance, MultiViewConsistencyMultipliesTheConfidenceFieldByV) {
  const auto cloud = wallWithSpike<TypeParam>();
  (*cloud)[20].z = 1.02f;  // one σ behind the wall
  MultiViewConsistency<TypeParam> filter(true);
  ConsistencyCase<TypeParam>::configure(filter);
  filter.setInputCloud(cloud);
  filter.setKeepOrganized(true);
  pcl::PointCloud<TypeParam> output;
  filter.filter(output);
  EXPECT_NEAR(filter.getConsistency()[20], std::exp(-1.0f), 1e-4f);
  EXPECT_EQ(filter.getViewCounts()[20], 1);
  EXPECT_NEAR(filter.getConsistency()[21], 1.0f, 1e-5f);
  EXPECT_NEAR(filter.getConsistency()[kSpike], ConsistencyParameters().free_space_penalty, 1e-6f);
  if constexpr (hasConfidence<TypeParam>) {
    EXPECT_NEAR(confidenceOf(output[20]), 0.5f * std::exp(-1.0f), 1e-4f);
    EXPECT_NEAR(confidenceOf(output[21]), 0.5f, 1e-5f);
    filter.setKeepOrganized(false);
    filter.setIndices(std::make_shared<pcl::Indices>(pcl::Indices{kSpike, 20}));
    filter.filter(output);
    ASSERT_EQ(output.size(), 1u);
    EXPECT_NEAR(confidenceOf(output[0]), 0.5f * std::exp(-1.0f), 1e-4f);
  }
}

TYPED_TEST(PointConformance, ConfidenceEstimationThrowsForAnUnorganisedCloud) {
  ConfidenceEstimation<TypeParam> filter;
  const auto cloud = std::make_shared<pcl::PointCloud<TypeParam>>(7, 1);
  filter.setInputCloud(cloud);
  pcl::Indices kept;
  pcl::PointCloud<TypeParam> output;
  expectThrow<pcl::UnorganizedPointCloudException>([&] { filter.filter(kept); }, {"ConfidenceEstimation", "7x1"});
  expectThrow<pcl::UnorganizedPointCloudException>([&] { filter.filter(output); }, {"ConfidenceEstimation", "7x1"});
}

TEST(ConfidenceEstimation, APointBehindTheSensorHasNoMeasurement) {
  const auto cloud = wallWithSpike<pcl::PointXYZ>();
  (*cloud)[30].z = -1;
  ConfidenceEstimation<pcl::PointXYZ> filter;
  filter.setInputCloud(cloud);
  pcl::Indices kept;
  for (const bool negative : {false, true}) {
    filter.setNegative(negative);
    filter.filter(kept);
    EXPECT_EQ(filter.getConfidence()[30], 0.0f);
    EXPECT_EQ(std::count(kept.begin(), kept.end(), 30), 0);
  }
}

TEST(ConfidenceEstimation, DepthIsAlongTheAxisOfTheSensorPose) {
  // The wall and its spike moved to where a sensor at (1, 2, 3) that looks along the world's x axis sees them.
  const auto cloud = wallWithSpike<PointFused>();
  ConfidenceEstimation<PointFused> filter;
  filter.setInputCloud(cloud);
  pcl::Indices before, after;
  filter.filter(before);
  const std::vector<float> C = filter.getConfidence();
  Eigen::Matrix3f R;
  R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  for (PointFused& p : *cloud) p.getVector3fMap() = R * p.getVector3fMap() + Eigen::Vector3f(1, 2, 3);
  cloud->sensor_origin_ << 1, 2, 3, 0;
  cloud->sensor_orientation_ = Eigen::Quaternionf(R);
  filter.filter(after);
  EXPECT_EQ(after, before);
  for (std::size_t i = 0; i < C.size(); ++i) EXPECT_NEAR(filter.getConfidence()[i], C[i], 1e-3f);
}

TEST(ConfidenceEstimation, KeepsOnlyWhatExceedsTheThreshold) {
  const auto cloud = wallWithSpike<pcl::PointXYZ>();
  ConfidenceEstimation<pcl::PointXYZ> filter;
  filter.setInputCloud(cloud);
  ConfidenceParameters parameters;
  parameters.threshold = 1.0f;  // C never exceeds 1
  filter.setParameters(parameters);
  pcl::Indices kept;
  filter.filter(kept);
  EXPECT_TRUE(kept.empty());
  parameters.threshold = 0.0f;
  filter.setParameters(parameters);
  filter.filter(kept);
  EXPECT_EQ(kept, allBut(kNotFinite));
}

TEST(MultiViewConsistency, KeepsWhatReachesTheThreshold) {
  const auto cloud = wallWithSpike<pcl::PointXYZ>();
  MultiViewConsistency<pcl::PointXYZ> filter;
  ConsistencyCase<pcl::PointXYZ>::configure(filter);
  filter.setInputCloud(cloud);
  filter.setThreshold(0.0f);
  pcl::Indices kept;
  filter.filter(kept);
  EXPECT_EQ(kept, allBut(kNotFinite));
}

TEST(MultiViewConsistency, WithoutAFrameItSaysSo) {
  MultiViewConsistency<pcl::PointXYZ> filter;
  filter.setInputCloud(wallWithSpike<pcl::PointXYZ>());
  pcl::Indices kept;
  expectThrow([&] { filter.filter(kept); }, {"RigFrame", "no camera"});
}

// ---------------------------------------------------------------------------------------------------------------------------
// DepthBackprojection.

/** \brief A 4 × 3 camera at (1, 2, 3) that looks along the world's x axis, its x towards −y and its y towards −z. */
Camera sidewaysCamera() {
  Camera camera;
  camera.name = "sideways";
  camera.intrinsics.width = 4;
  camera.intrinsics.height = 3;
  camera.intrinsics.fx = camera.intrinsics.fy = 2;
  camera.intrinsics.cx = camera.intrinsics.cy = 1;
  camera.T_world_camera.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  camera.T_world_camera.translation() << 1, 2, 3;
  return camera;
}

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

TYPED_TEST(PointConformance, DepthBackprojectionPutsEveryPixelOfACloudWhereHandCalculationDoes) {
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
  for (std::size_t i = 0; i < 12; ++i) EXPECT_TRUE(sameFields(output[i], (*cloud)[i], false)) << "pixel " << i;
}

TYPED_TEST(PointConformance, DepthBackprojectionOfAViewAgreesWithThatOfACloud) {
  DepthBackprojection<TypeParam> filter(true);
  filter.setCamera(sidewaysCamera());
  filter.setView(depthView());
  pcl::PointCloud<TypeParam> output;
  filter.filter(output);
  expectBackprojectedByHand(output);
  EXPECT_EQ(*filter.getRemovedIndices(), kNoDepth);
  EXPECT_FALSE(output.is_dense);
}

TYPED_TEST(PointConformance, DepthBackprojectionGivesTheCamerasPoseAndTheCloudsHeader) {
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

TYPED_TEST(PointConformance, DepthBackprojectionRestrictsItselfToTheIndices) {
  for (const bool from_view : {false, true}) {
    DepthBackprojection<TypeParam> filter;
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
  }
}

TYPED_TEST(PointConformance, DepthBackprojectionWritesTheUserFilterValueWhereThereIsNoDepth) {
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

TYPED_TEST(PointConformance, DepthBackprojectionFiltersInPlace) {
  const auto cloud = depthCloud<TypeParam>();
  DepthBackprojection<TypeParam> filter;
  filter.setCamera(sidewaysCamera());
  filter.setInputCloud(cloud);
  pcl::PointCloud<TypeParam> elsewhere;
  filter.filter(elsewhere);
  filter.filter(*cloud);
  EXPECT_TRUE(sameClouds(*cloud, elsewhere));
}

TYPED_TEST(PointConformance, DepthBackprojectionColoursThePointsOfAViewThatHasColour) {
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

TEST(DepthBackprojection, SixteenBitDepthHasAScaleAndTwoNumbersThatMeanNothing) {
  const std::vector<std::uint16_t> raw{1000, 0, 500, 65535, 250, 1000, 1000, 1000, 1000, 1000, 1000, 4000};
  DepthView view;
  view.depth16 = {raw.data(), 4, 3};
  view.depth_scale = 0.002f;
  DepthBackprojection<pcl::PointXYZ> filter(true);
  Camera camera = sidewaysCamera();
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

// ---------------------------------------------------------------------------------------------------------------------------
// AdaptiveHashFusion.

/** \brief A grid of points 20 mm apart on the plane z = 1, C = 0.8. */
template <typename P>
typename pcl::PointCloud<P>::Ptr plane() {
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
pcl::PointCloud<P> fuse(AdaptiveHashFusion<P>& filter, const typename pcl::PointCloud<P>::ConstPtr& cloud) {
  pcl::PointCloud<P> output;
  filter.setInputCloud(cloud);
  filter.filter(output);
  return output;
}

template <typename P>
pcl::PointCloud<P> fuse(const typename pcl::PointCloud<P>::ConstPtr& cloud) {
  AdaptiveHashFusion<P> filter;
  return fuse(filter, cloud);
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

TYPED_TEST(PointConformance, FusionOfAPlaneStaysInsideItsHull) {
  const auto output = fuse<TypeParam>(plane<TypeParam>());
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

TYPED_TEST(PointConformance, FusionWritesTheWeightToConfidenceElseToIntensity) {
  const auto output = fuse<TypeParam>(plane<TypeParam>());
  ASSERT_FALSE(output.empty());
  for (const TypeParam& p : output) {
    if constexpr (hasConfidence<TypeParam>) {
      EXPECT_NEAR(confidenceOf(p), 0.8f, 1e-5f);
    } else if constexpr (point::has<TypeParam, pcl::fields::intensity>) {
      EXPECT_NEAR(p.intensity, 1.0f, 1e-5f);
    }
    if constexpr (point::has<TypeParam, pcl::fields::view_count>) {
      EXPECT_EQ(p.view_count, 1u);
    }
  }
}

TYPED_TEST(PointConformance, FusionCarriesHeaderAndSensorPoseOver) {
  expectHeaderAndPose(fuse<TypeParam>(plane<TypeParam>()));
}

TYPED_TEST(PointConformance, FusionFiltersInPlace) {
  const auto cloud = plane<TypeParam>();
  AdaptiveHashFusion<TypeParam> filter;
  const auto elsewhere = fuse(filter, cloud);
  filter.filter(*cloud);
  EXPECT_TRUE(sameClouds(*cloud, elsewhere));
  expectHeaderAndPose(*cloud);
}

TYPED_TEST(PointConformance, FusionOfAnEmptyCloudIsEmpty) {
  AdaptiveHashFusion<TypeParam> filter(true);
  filter.setInputCloud(std::make_shared<pcl::PointCloud<TypeParam>>());
  pcl::PointCloud<TypeParam> output = *plane<TypeParam>();
  ASSERT_NO_THROW(filter.filter(output));
  EXPECT_TRUE(output.empty());
  EXPECT_TRUE(filter.getRemovedIndices()->empty());
}

TYPED_TEST(PointConformance, FusionSkipsPointsThatAreNotFinite) {
  const auto cloud = plane<TypeParam>();
  const auto clean = fuse<TypeParam>(cloud);
  for (const float bad : {kNaN, kInf, -kInf}) {
    cloud->push_back(distinctPoint<TypeParam>(bad, 0, 1, 1));
    cloud->insert(cloud->begin(), distinctPoint<TypeParam>(0, bad, 1, 1));
    cloud->insert(cloud->begin() + 100, distinctPoint<TypeParam>(0, 0, bad, 1));
  }
  cloud->is_dense = false;
  const auto output = fuse<TypeParam>(cloud);
  EXPECT_TRUE(sameClouds(output, clean));
  EXPECT_TRUE(output.is_dense);
}

TYPED_TEST(PointConformance, FusionSkipsPointsWithoutConfidence) {
  if constexpr (!hasConfidence<TypeParam>) {
    GTEST_SKIP() << "no confidence field";
  } else {
    const auto cloud = plane<TypeParam>();
    const auto clean = fuse<TypeParam>(cloud);
    for (const float C : {0.0f, -1.0f, kNaN}) {
      cloud->push_back(distinctPoint<TypeParam>(0.001f, 0.001f, 1.01f, 1));
      setConfidence(cloud->back(), C);
    }
    EXPECT_TRUE(sameClouds(fuse<TypeParam>(cloud), clean));
  }
}

TYPED_TEST(PointConformance, FusionHonoursIndices) {
  const auto cloud = plane<TypeParam>();
  const auto half = std::make_shared<pcl::PointCloud<TypeParam>>(*cloud, pcl::Indices{3, 4, 5, 30, 200});
  AdaptiveHashFusion<TypeParam> filter;
  filter.setIndices(std::make_shared<pcl::Indices>(pcl::Indices{3, 4, 5, 30, 200}));
  EXPECT_TRUE(sameClouds(fuse(filter, cloud), fuse<TypeParam>(half)));
}

TYPED_TEST(PointConformance, FusionRemovesThePointsThatRepresentNoOutputPoint) {
  // One cell, three of whose four points stand for it: the most confident ones, or the first ones. The first point is
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
    EXPECT_EQ(fuse(filter, cloud).size(), 1u);
    const pcl::Indices expected{0, hasConfidence<TypeParam> ? 1 : 4};
    EXPECT_EQ(*filter.getRemovedIndices(), extract ? expected : pcl::Indices());
  }
}

TYPED_TEST(PointConformance, FusionNamesAPointThatIsTooFarOut) {
  const auto cloud = plane<TypeParam>();
  cloud->push_back(distinctPoint<TypeParam>(0.5f, 1e7f, 0.25f, 1));
  AdaptiveHashFusion<TypeParam> filter;
  expectThrow<pcl::PCLException>([&] { fuse(filter, cloud); }, {"AdaptiveHashFusion", "(0.5, 1e+07, 0.25)"});
}

TYPED_TEST(PointConformance, FusionOfTwoPointsInACellIsTheirWeightedMeanByHand) {
  AdaptiveHashFusion<TypeParam> filter;
  filter.setCameraIndices({0, 1});
  const auto output = fuse(filter, twoPointsInACell<TypeParam>());
  ASSERT_EQ(output.size(), 1u);
  const float share = hasConfidence<TypeParam> ? 0.25f : 0.5f;  // of the second
  EXPECT_NEAR(output[0].x, 0.101f + share * 0.004f, 1e-6f);
  EXPECT_NEAR(output[0].y, 0.101f + share * 0.008f, 1e-6f);
  EXPECT_NEAR(output[0].z, 1.001f + share * 0.004f, 1e-6f);
  // Σ ω² / Σ ω = (0.81 + 0.09) / 1.2.
  if constexpr (hasConfidence<TypeParam>) {
    EXPECT_NEAR(confidenceOf(output[0]), 0.75f, 1e-5f);
  }
  if constexpr (point::has<TypeParam, pcl::fields::view_count>) {
    EXPECT_EQ(output[0].view_count, 2u);
  }
}

TYPED_TEST(PointConformance, FusionCarriesTheFieldsItDoesNotKnowFromTheMainRepresentative) {
  if constexpr (!hasConfidence<TypeParam>) {
    GTEST_SKIP() << "no confidence field: both points weigh the same";
  } else {
    const auto cloud = twoPointsInACell<TypeParam>();
    for (const bool swap : {false, true}) {
      if (swap) std::swap((*cloud)[0], (*cloud)[1]);
      AdaptiveHashFusion<TypeParam> filter;
      filter.setCameraIndices({0, 1});
      const auto output = fuse(filter, cloud);
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

TYPED_TEST(PointConformance, FusionAveragesColourByHand) {
  if constexpr (!point::has_color<TypeParam>) {
    GTEST_SKIP() << "no colour field";
  } else {
    const auto cloud = twoPointsInACell<TypeParam>();
    point::setColor((*cloud)[0], {100, 50, 0});
    point::setColor((*cloud)[1], {200, 150, 200});
    AdaptiveHashFusion<TypeParam> filter;
    filter.setCameraIndices({0, 1});
    const auto output = fuse(filter, cloud);
    ASSERT_EQ(output.size(), 1u);
    EXPECT_EQ(output[0].r, hasConfidence<TypeParam> ? 125 : 150);
    EXPECT_EQ(output[0].g, hasConfidence<TypeParam> ? 75 : 100);
    EXPECT_EQ(output[0].b, hasConfidence<TypeParam> ? 50 : 100);
    EXPECT_EQ(output[0].a, 255);
  }
}

TYPED_TEST(PointConformance, FusionAveragesNormalsByHandToUnitLength) {
  if constexpr (!point::has_normal<TypeParam>) {
    GTEST_SKIP() << "no normal";
  } else {
    const auto cloud = twoPointsInACell<TypeParam>();
    point::setNormal((*cloud)[0], {0, 0, -1});
    point::setNormal((*cloud)[1], {0, -1, 0});
    AdaptiveHashFusion<TypeParam> filter;
    filter.setCameraIndices({0, 1});
    const auto output = fuse(filter, cloud);
    ASSERT_EQ(output.size(), 1u);
    const float first = hasConfidence<TypeParam> ? 0.75f : 0.5f;
    const float norm = std::sqrt(first * first + (1 - first) * (1 - first));
    EXPECT_NEAR(output[0].normal_x, 0, 1e-6f);
    EXPECT_NEAR(output[0].normal_y, -(1 - first) / norm, 1e-5f);
    EXPECT_NEAR(output[0].normal_z, -first / norm, 1e-5f);
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
    const auto a = fuse(filter, cloud);
    filter.setCameraIndices(shuffled_cameras);
    const auto b = fuse(filter, shuffled);
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
    const auto one = fuse(filter, cloud);
    const pcl::Indices removed = *filter.getRemovedIndices();
    ASSERT_GT(one.size(), 1000u);
    for (const unsigned int threads : {2u, 3u, 0u}) {
      filter.setNumberOfThreads(threads);
      EXPECT_TRUE(sameClouds(fuse(filter, cloud), one)) << threads << " threads";
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
    expectThrow<pcl::PCLException>([&] { fuse(filter, cloud); }, {"(2e+07, "});
  }
}

TEST(AdaptiveHashFusion, CellsAreFixedToTheWorldSoThatPointsFarAwayChangeNothing) {
  const auto cloud = scattered(3000);
  const auto alone = fuse<PointFused>(cloud);
  const auto more = std::make_shared<pcl::PointCloud<PointFused>>();
  for (const float far : {-7.123f, 5.017f}) {
    for (int i = 0; i < 50; ++i) {
      more->push_back(distinctPoint<PointFused>(far, far + 0.003f * static_cast<float>(i), -far, 1));
      more->back().confidence = 0.9f;
    }
    if (far < 0) *more += *cloud;
  }
  pcl::PointCloud<PointFused> near;
  for (const PointFused& p : fuse<PointFused>(more))
    if (std::fabs(p.x) < 2) near.push_back(p);
  EXPECT_TRUE(sameClouds(near, alone));
}

TEST(AdaptiveHashFusion, PointsInDifferentCellsOnEitherSideOfTheOriginStayApart) {
  const auto cloud = std::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  for (const float x : {-0.001f, 0.001f})
    for (const float y : {-0.001f, 0.001f})
      for (const float z : {-0.001f, 0.001f}) cloud->push_back({x, y, z});
  const auto output = fuse<pcl::PointXYZ>(cloud);
  ASSERT_EQ(output.size(), 8u);
  for (const pcl::PointXYZ& p : output) EXPECT_NEAR(p.getVector3fMap().cwiseAbs().minCoeff(), 0.001f, 1e-7f);
}

TEST(AdaptiveHashFusion, CellsFollowTheLocalDensityByHand) {
  // Sixteen points in one coarse cell of 64 mm want 4² = 16 children: side 16 mm, a point in each of the 4 × 4.
  const auto dense = std::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  for (int i = 0; i < 16; ++i)
    dense->push_back(
        {0.008f + 0.016f * static_cast<float>(i % 4), 0.008f + 0.016f * static_cast<float>(i / 4), 0.008f});
  EXPECT_EQ(fuse<pcl::PointXYZ>(dense).size(), 16u);
  // Four of them want four children of 32 mm: these four share one.
  const auto sparse = std::make_shared<pcl::PointCloud<pcl::PointXYZ>>(*dense, pcl::Indices{0, 1, 4, 5});
  const auto output = fuse<pcl::PointXYZ>(sparse);
  ASSERT_EQ(output.size(), 1u);
  EXPECT_NEAR(output[0].x, 0.016f, 1e-6f);
  EXPECT_NEAR(output[0].y, 0.016f, 1e-6f);
  // No cell is smaller than the smallest.
  AggregationParameters parameters;
  parameters.min_cell_size = 0.064f;
  AdaptiveHashFusion<pcl::PointXYZ> coarse;
  coarse.setParameters(parameters);
  EXPECT_EQ(fuse(coarse, dense).size(), 1u);
}

TEST(AdaptiveHashFusion, DropsAPointUnderTheLeastWeight) {
  const auto cloud = std::make_shared<pcl::PointCloud<PointFused>>();
  for (const float C : {0.1f, 0.3f}) {
    cloud->push_back(distinctPoint<PointFused>(C, 0, 0, 1));  // cells apart
    cloud->back().confidence = C;
  }
  AdaptiveHashFusion<PointFused> filter;
  EXPECT_EQ(fuse(filter, cloud).size(), 2u);  // weak, but alone
  AggregationParameters parameters;
  parameters.min_weight = 0.2f;
  filter.setParameters(parameters);
  const auto output = fuse(filter, cloud);
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
  const auto output = fuse(filter, cloud);
  ASSERT_EQ(output.size(), 1u);
  EXPECT_NEAR(output[0].x, 0.01f, 1e-6f);
  AggregationParameters parameters;
  parameters.weak_weight = 0;
  filter.setParameters(parameters);
  EXPECT_EQ(fuse(filter, cloud).size(), 2u);
}

/** \brief Six points of four cameras in one cell that is not refined; x in millimetres is 1, 2, 4, 8, 16, 32. */
class SixPointsOfFourCameras : public ::testing::Test {
 protected:
  SixPointsOfFourCameras() {
    // In mixed order: points are told apart by camera, not by place.
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
    const auto output = fuse(filter, cloud);
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

  // V is 1 for the first and 1/e for the second.
  parameters.consistency_at = ConsistencyAt::Representatives;
  filter.setParameters(parameters);
  auto output = fuse(filter, cloud);
  ASSERT_EQ(output.size(), 1u);
  const float V = std::exp(-1.0f);
  EXPECT_NEAR(output[0].z, (2.0f + V * 2.02f) / (1 + V), 1e-5f);
  EXPECT_NEAR(output[0].intensity, (1 + V * V) / (1 + V), 1e-4f);

  // Their mean is half a σ behind the wall, whichever camera is asked.
  parameters.consistency_at = ConsistencyAt::CellMean;
  filter.setParameters(parameters);
  output = fuse(filter, cloud);
  ASSERT_EQ(output.size(), 1u);
  EXPECT_NEAR(output[0].z, 2.01f, 1e-5f);
  EXPECT_NEAR(output[0].intensity, std::exp(-0.25f), 1e-4f);

  filter.setCameraIndices({0, 2});
  expectThrow([&] { fuse(filter, cloud); }, {"AdaptiveHashFusion", "point 1", "camera 2", "has 2"});
}

TEST(AdaptiveHashFusion, CountsCameraIndicesAndPointsIfTheyDiffer) {
  AdaptiveHashFusion<pcl::PointXYZ> filter;
  filter.setCameraIndices({0, 1, 2});
  expectThrow([&] { fuse(filter, plane<pcl::PointXYZ>()); }, {"AdaptiveHashFusion", "3 camera indices", "400 points"});
}

// ---------------------------------------------------------------------------------------------------------------------------
// Bad parameters.

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

TEST(BadParameters, ConfidenceEstimationNamesThem) {
  using Filter = ConfidenceEstimation<pcl::PointXYZ>;
  using P = ConfidenceParameters;
  const char* owner = "ConfidenceEstimation";
  expectRejected<Filter>(&P::alpha, -1.0f, owner, "alpha", "-1");
  expectRejected<Filter>(&P::beta, -0.5f, owner, "beta", "-0.5");
  expectRejected<Filter>(&P::gamma, kNaN, owner, "gamma", "nan");
  expectRejected<Filter>(&P::delta, kInf, owner, "delta", "inf");
  expectRejected<Filter>(&P::threshold, 1.5f, owner, "threshold", "1.5");
  expectRejected<Filter>(&P::threshold, kNaN, owner, "threshold", "nan");
  expectRejected<Filter>(&P::length_unit, 0.0f, owner, "length_unit", "0");
  expectRejected<Filter>(&P::noise_floor, -1.0f, owner, "noise_floor", "-1");
  expectRejected<Filter>(&P::noise_quadratic, -1.0f, owner, "noise_quadratic", "-1");
  expectRejected<Filter>(&P::noise_reference, 0.0f, owner, "noise_reference", "0");
  expectRejected<Filter>(&P::max_incidence, 0.0f, owner, "max_incidence", "0");
  expectRejected<Filter>(&P::max_incidence, 2.0f, owner, "max_incidence", "2");
  P parameters;
  parameters.alpha = parameters.gamma = 0;
  Filter filter;
  expectThrow([&] { filter.setParameters(parameters); }, {owner, "alpha + gamma is 0"});
  for (const float f : {0.0f, -1.0f, kNaN, kInf})
    EXPECT_THROW(filter.setFocalLength(f), pcl::BadArgumentException) << f;
  expectThrow([&] { filter.setFocalLength(-3); }, {owner, "focal length is -3"});
}

TEST(BadParameters, MultiViewConsistencyNamesThem) {
  using Filter = MultiViewConsistency<pcl::PointXYZ>;
  using P = ConsistencyParameters;
  const char* owner = "MultiViewConsistency";
  expectRejected<Filter>(&P::sigma, 0.0f, owner, "sigma", "0");
  expectRejected<Filter>(&P::sigma, kNaN, owner, "sigma", "nan");
  expectRejected<Filter>(&P::sigma_per_noise, -1.0f, owner, "sigma_per_noise", "-1");
  expectRejected<Filter>(&P::margin, 0.0f, owner, "margin", "0");
  expectRejected<Filter>(&P::free_space_penalty, 0.0f, owner, "free_space_penalty", "0");
  expectRejected<Filter>(&P::free_space_penalty, 1.5f, owner, "free_space_penalty", "1.5");
  expectRejected<Filter>(&P::max_views, 1, owner, "max_views", "1");
  expectRejected<Filter>(&P::max_candidates, 3, owner, "max_candidates", "3");
  Filter filter;
  expectThrow([&] { filter.setThreshold(1.25f); }, {owner, "threshold is 1.25"});
  expectThrow([&] { filter.setThreshold(kNaN); }, {owner, "threshold is nan"});
  RigFrame frame;
  frame.cameras = {sidewaysCamera()};
  frame.views.resize(1);
  expectThrow([&] { filter.setFrame(frame, 1); }, {owner, "source_camera is 1"});
  expectThrow([&] { filter.setFrame(frame, -2); }, {owner, "source_camera is -2"});
  EXPECT_NO_THROW(filter.setFrame(frame, 0));
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
}

}  // namespace
