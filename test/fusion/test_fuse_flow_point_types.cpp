#include "../conformance_points.h"
#include "../scenes.h"

#include <fuse_flow/point_traits.h>

#include <pcl/conversions.h>

#include <algorithm>

// Compiled once, in instances.cpp.
extern template class fuse_flow::FuseFlow<pcl::PointXYZ>;
extern template class fuse_flow::FuseFlow<conformance::OddPoint>;
#if !defined(FUSE_FLOW_TEST_FEW_POINT_TYPES)
extern template class fuse_flow::FuseFlow<pcl::PointXYZI>;
extern template class fuse_flow::FuseFlow<pcl::PointXYZRGB>;
extern template class fuse_flow::FuseFlow<pcl::PointSurfel>;
#endif

// The frame pipeline for every point type: each gets the fields that it has.

namespace {

/** \brief What a lidar's driver may define: fields of the library's names, whose types mean something else. */
struct EIGEN_ALIGN16 LidarPoint {
  PCL_ADD_POINT4D
  std::uint8_t intensity{7};
  std::uint8_t view_count{8};
  std::uint16_t ring{9};
  double confidence{10};
  PCL_MAKE_ALIGNED_OPERATOR_NEW
};

}  // namespace

POINT_CLOUD_REGISTER_POINT_STRUCT(LidarPoint,
                                  (float, x, x)(float, y, y)(float, z, z)(std::uint8_t, intensity, intensity)(
                                      std::uint8_t, view_count, view_count)(std::uint16_t, ring,
                                                                            ring)(double, confidence, confidence))

namespace {

TEST(PointTraits, AFieldOfAnotherTypeIsLeftAlone) {
  namespace point = fuse_flow::point;
  LidarPoint p;
  point::setPosition(p, {1, 2, 3});
  point::setIntensity(p, 0.5f);
  point::setCameraMask(p, 1);
  point::setConfidence(p, 0.5f);
  point::setViewCount(p, 0xffffffffu);
  EXPECT_EQ(p.z, 3.0f);
  EXPECT_EQ(p.intensity, 7);
  EXPECT_EQ(p.view_count, 8);
  EXPECT_EQ(p.ring, 9);
  EXPECT_EQ(p.confidence, 10.0);
  EXPECT_EQ(point::getConfidence(p), 1.0f);  // as of a point without
}

TEST(PointTraits, ThePointsMaskGoesThroughPclsMessagesAndBack) {
  using PointT = fuse_flow::PointFusedCameras;
  pcl::PointCloud<PointT> cloud(2, 1), back;
  fuse_flow::point::setCameraMask(cloud[1], std::uint64_t{1} << 63 | 5u);
  cloud[1].view_count = 3;
  pcl::PCLPointCloud2 message;
  pcl::toPCLPointCloud2(cloud, message);
  const auto field = std::find_if(message.fields.begin(), message.fields.end(),
                                  [](const pcl::PCLPointField& f) { return f.name == "camera_mask"; });
  ASSERT_NE(field, message.fields.end());
  EXPECT_EQ(field->count, 2u);
  EXPECT_EQ(field->datatype, pcl::PCLPointField::UINT32);
  pcl::fromPCLPointCloud2(message, back);
  ASSERT_EQ(back.size(), 2u);
  EXPECT_EQ(fuse_flow::point::getCameraMask(back[0]), 0u);
  EXPECT_EQ(fuse_flow::point::getCameraMask(back[1]), std::uint64_t{1} << 63 | 5u);
  EXPECT_EQ(back[1].view_count, 3u);
  EXPECT_TRUE(back[1].isFrom(0) && !back[1].isFrom(1) && back[1].isFrom(2) && back[1].isFrom(63));
}

template <typename P>
class FuseFlowOf : public ::testing::Test {};

TYPED_TEST_SUITE(FuseFlowOf, conformance::PointTypes, conformance::PointName);

TYPED_TEST(FuseFlowOf, PutsPointsWhereTheirRaysMeetAWallAndFillsTheFieldsThatTheyHave) {
  namespace fields = pcl::fields;
  namespace point = fuse_flow::point;
  const scenes::Vector3d n = scenes::Vector3d(0.2, -0.1, 1).normalized();
  scenes::Scene scene = scenes::makeScene(scenes::sameCameras(2, 40, 30, 40), scenes::plane(n, 1.5));
  scene.paint({200, 100, 50});
  scene.confidence.assign(2, scenes::uniform(40, 30, 0.75f));
  scene.attach();
  fuse_flow::FuseFlowParameters parameters;
  parameters.use_measurement_confidence = false;  // ω is what the sensor says
  const std::vector<scenes::Vector3d> measured = scenes::backProjected(scene);
  for (const bool hash : {false, true}) {
    parameters.use_spatial_hash = hash;
    fuse_flow::FuseFlow<TypeParam> fusion;
    fusion.setParameters(parameters);
    fusion.setNumberOfThreads(2);
    fusion.setComputeNormals(true);
    pcl::PointCloud<TypeParam> cloud;
    fusion.setWeightInIntensity(true);
    fusion.fuse(scene.rig, cloud);
    if constexpr (point::has_intensity<TypeParam>) {
      for (const TypeParam& p : cloud) ASSERT_NEAR(point::getIntensity(p), 0.75f, 1e-4f);
    }
    fusion.setWeightInIntensity(false);
    fusion.fuse(scene.rig, cloud);
    ASSERT_GT(cloud.size(), 300u);
    if (!hash) {
      ASSERT_EQ(cloud.size(), measured.size());
    }
    for (std::size_t k = 0; k < cloud.size(); ++k) {
      const TypeParam& p = cloud[k];
      const scenes::Vector3d position(p.x, p.y, p.z);
      ASSERT_NEAR(n.dot(position), 1.5, 3e-6);
      if (!hash) {
        ASSERT_LT((position - measured[k]).norm(), 3e-6);  // pixel by pixel
      }
      if constexpr (point::has_confidence<TypeParam>) {
        ASSERT_NEAR((point::getField<fields::confidence, float>(p)), 0.75f, 1e-4f);
      }
      if constexpr (point::has_intensity<TypeParam>) {  // the luminance of its colour
        ASSERT_NEAR((point::getField<fields::intensity, float>(p)), 0.299f * 200 + 0.587f * 100 + 0.114f * 50, 1e-3f);
      }
      if constexpr (point::has_view_count<TypeParam>) {
        ASSERT_EQ((point::getField<fields::view_count, std::uint32_t>(p)), 2u);
      }
      if constexpr (point::has_color<TypeParam>) {
        ASSERT_EQ((std::array<int, 4>{p.r, p.g, p.b, p.a}), (std::array<int, 4>{200, 100, 50, 255}));
      }
      if constexpr (point::has_normal<TypeParam>) {  // towards the cameras
        ASSERT_LT((p.getNormalVector3fMap().template cast<double>() + n).norm(), 1e-3);
      }
      if constexpr (std::is_same_v<TypeParam, conformance::OddPoint>) {
        ASSERT_EQ(p.m_warmth, 0.0f);
        ASSERT_EQ(p.m_serial, 0u);
        ASSERT_EQ(p.preamble, 0.0);
      }
    }
  }
}

}  // namespace
