#include "filter_conformance.h"

#include <fuse_flow/filters/confidence_estimation.h>
#include <fuse_flow/filters/multi_view_consistency.h>

#include <gtest/gtest.h>

#include <numeric>
#include <set>

// The filters that choose points, ConfidenceEstimation and MultiViewConsistency, after PCL's conventions.

namespace {

using namespace fuse_flow;
using namespace filter_conformance;

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
class IndexFilterOf : public ::testing::Test {};

TYPED_TEST_SUITE(IndexFilterOf, PointTypes, PointName);

TYPED_TEST(IndexFilterOf, ConfidenceEstimationWritesCToTheConfidenceField) {
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

TYPED_TEST(IndexFilterOf, MultiViewConsistencyMultipliesTheConfidenceFieldByV) {
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

TYPED_TEST(IndexFilterOf, ConfidenceEstimationThrowsForAnUnorganisedCloud) {
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
  expectRejected<Filter>(&P::noise_reference, 0.0f, owner, "noise_reference", "0");
  expectRejected<Filter>(&P::max_incidence, 0.0f, owner, "max_incidence", "0");
  expectRejected<Filter>(&P::max_incidence, 2.0f, owner, "max_incidence", "2");
  P parameters;
  parameters.alpha = parameters.gamma = 0;
  Filter filter;
  expectThrow([&] { filter.setParameters(parameters); }, {owner, "alpha + gamma is 0"});
  for (const auto& [noise, message] : {std::pair{NoiseModel{-1, 0, 0}, "noise.floor is -1"},
                                       {NoiseModel{0, kNaN, 0}, "noise.linear is nan"},
                                       {NoiseModel{0, 0, -1}, "noise.quadratic is -1"},
                                       {NoiseModel{0, 0, 0}, "noise.floor + noise.linear + noise.quadratic is 0"}}) {
    P noisy;
    noisy.noise = noise;
    expectThrow([&] { filter.setParameters(noisy); }, {owner, message});
  }
  P given;
  given.form = ConfidenceForm::Given;
  expectThrow([&] { filter.setParameters(given); }, {owner, "form is Given"});
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
  expectRejected<Filter>(&P::min_facing, 1.5f, owner, "min_facing", "1.5");
  expectRejected<Filter>(&P::min_facing, kNaN, owner, "min_facing", "nan");
  expectRejected<Filter>(&P::silhouette_radius, -1, owner, "silhouette_radius", "-1");
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

}  // namespace
