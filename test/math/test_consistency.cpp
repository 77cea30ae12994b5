#include <fuse_flow/filters/multi_view_consistency.h>
#include <fuse_flow/math/consistency.h>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace {

using namespace fuse_flow;

ConsistencyParameters form(OcclusionForm occlusion, DistanceForm distance) {
  ConsistencyParameters p;
  p.occlusion = occlusion;
  p.distance = distance;
  p.sigma = 0.02f;
  return p;
}

float V(const ConsistencyParameters& p, const std::vector<ViewOpinion>& opinions) {
  Consistency c;
  for (const ViewOpinion& opinion : opinions) c.add(p, opinion);
  return consistency(p, c);
}

TEST(ViewOpinion, AlongTheRayOnlyDepthCounts) {
  const ConsistencyParameters p = form(OcclusionForm::OcclusionAware, DistanceForm::AlongRay);
  // 20 mm behind the measurement and 30 mm beside the ray: (20/20)².
  const ViewOpinion opinion = viewOpinion(p, {0.03f, 0, 1.02f}, {0, 0}, 1.0f);
  EXPECT_EQ(opinion.verdict, ViewOpinion::Distance);
  EXPECT_NEAR(opinion.squared_distance, 1.0f, 1e-4f);
}

TEST(ViewOpinion, TheEuclideanDistanceIncludesWhatIsSideways) {
  const ConsistencyParameters p = form(OcclusionForm::OcclusionAware, DistanceForm::Euclidean);
  // Q = (0.5, 0, 1); the point is 20 mm behind and 30 mm beside: (20² + 30²) / 20².
  const ViewOpinion opinion = viewOpinion(p, {0.53f, 0, 1.02f}, {0.5f, 0}, 1.0f);
  EXPECT_EQ(opinion.verdict, ViewOpinion::Distance);
  EXPECT_NEAR(opinion.squared_distance, 3.25f, 1e-3f);
}

TEST(ViewOpinion, APointFarBehindTheMeasurementIsHidden) {
  const ConsistencyParameters p = form(OcclusionForm::OcclusionAware, DistanceForm::AlongRay);
  EXPECT_EQ(viewOpinion(p, {0, 0, 1.049f}, {}, 1.0f).verdict, ViewOpinion::Distance);  // 2.45 σ
  EXPECT_EQ(viewOpinion(p, {0, 0, 1.051f}, {}, 1.0f).verdict, ViewOpinion::Hidden);    // 2.55 σ
  EXPECT_EQ(viewOpinion(p, {0, 0, 9.0f}, {}, 1.0f).verdict, ViewOpinion::Hidden);
}

TEST(ViewOpinion, APointFarBeforeTheMeasurementIsSeenThrough) {
  const ConsistencyParameters p = form(OcclusionForm::OcclusionAware, DistanceForm::AlongRay);
  EXPECT_EQ(viewOpinion(p, {0, 0, 0.951f}, {}, 1.0f).verdict, ViewOpinion::Distance);
  EXPECT_EQ(viewOpinion(p, {0, 0, 0.949f}, {}, 1.0f).verdict, ViewOpinion::SeenThrough);
}

TEST(ViewOpinion, AtTheMarginThePointIsStillOfTheSurface) {
  // All of these are exact: σ is a 16th, the margin an 8th of a metre.
  ConsistencyParameters p = form(OcclusionForm::OcclusionAware, DistanceForm::AlongRay);
  p.sigma = 0.0625f;
  p.margin = 2;
  EXPECT_EQ(viewOpinion(p, {0, 0, 1.125f}, {}, 1.0f).verdict, ViewOpinion::Distance);
  EXPECT_EQ(viewOpinion(p, {0, 0, std::nextafter(1.125f, 2.0f)}, {}, 1.0f).verdict, ViewOpinion::Hidden);
  EXPECT_EQ(viewOpinion(p, {0, 0, 0.875f}, {}, 1.0f).verdict, ViewOpinion::Distance);
  EXPECT_EQ(viewOpinion(p, {0, 0, std::nextafter(0.875f, 0.0f)}, {}, 1.0f).verdict, ViewOpinion::SeenThrough);
  // The other view's measurement stands for the point up to σ.
  EXPECT_TRUE(agrees(viewOpinion(p, {0, 0, 1.0625f}, {}, 1.0f)));
  EXPECT_FALSE(agrees(viewOpinion(p, {0, 0, std::nextafter(1.0625f, 2.0f)}, {}, 1.0f)));
}

TEST(Silhouette, IsWhatWasMeasuredBesideWithinReachAndMoreThanThatBeforeWhatIsBehind) {
  ConsistencyParameters p = form(OcclusionForm::OcclusionAware, DistanceForm::AlongRay);
  p.sigma = 0.0625f;
  p.margin = 2;  // a reach of an 8th of a metre
  p.silhouette_radius = 1;
  // The point is at 1 m; the view measured behind at the pixel itself, and beside at one of the eight around it.
  const auto isBeside = [&p](float behind, float beside, int a, int b) {
    return isBesideSilhouette(
        p, 1, [=](int x, int y) { return x == 0 && y == 0 ? behind : (x == a && y == b ? beside : 0.0f); });
  };
  EXPECT_TRUE(isBeside(2, 1, 1, 0));
  EXPECT_TRUE(isBeside(2, 1, -1, -1));
  EXPECT_TRUE(isBeside(2, 1, 1, 1));
  EXPECT_FALSE(isBeside(2, 1, 2, 0)) << "beyond the radius";
  EXPECT_FALSE(isBeside(2, 1, 0, -2)) << "beyond the radius";
  EXPECT_TRUE(isBeside(2, 1.125f, 1, 0)) << "as far as the reach";
  EXPECT_FALSE(isBeside(2, std::nextafter(1.125f, 2.0f), 1, 0));
  EXPECT_TRUE(isBeside(2, 0.875f, 1, 0));
  EXPECT_FALSE(isBeside(2, std::nextafter(0.875f, 0.0f), 1, 0));
  EXPECT_FALSE(isBeside(1.125f, 1, 1, 0)) << "no edge between the two";
  EXPECT_TRUE(isBeside(std::nextafter(1.125f, 2.0f), 1, 1, 0));
  p.sigma = 1;
  EXPECT_FALSE(isBeside(9, 0, 1, 0)) << "a hole, whatever the reach";
}

TEST(ViewOpinion, AsPublishedEveryViewCountsHoweverFarOff) {
  const ConsistencyParameters p = form(OcclusionForm::Published, DistanceForm::AlongRay);
  const ViewOpinion behind = viewOpinion(p, {0, 0, 1.2f}, {}, 1.0f);
  EXPECT_EQ(behind.verdict, ViewOpinion::Distance);
  EXPECT_NEAR(behind.squared_distance, 100.0f, 1e-2f);
  const ViewOpinion before = viewOpinion(p, {0, 0, 0.8f}, {}, 1.0f);
  EXPECT_EQ(before.verdict, ViewOpinion::Distance);
  EXPECT_NEAR(before.squared_distance, 100.0f, 1e-2f);
}

TEST(IsAsked, OnlyAViewThatTheSurfaceFaces) {
  ConsistencyParameters p;
  p.min_facing = 0.1f;  // 84.26°
  const auto asked = [&p](double degrees, float length) {
    const double angle = degrees * M_PI / 180;
    return isAsked(p, {0, 0, -length},
                   {3 * static_cast<float>(std::sin(angle)), 0, -3 * static_cast<float>(std::cos(angle))});
  };
  for (const float length : {1.0f, 1e-5f, 40.0f}) {
    EXPECT_TRUE(asked(0, length));
    EXPECT_TRUE(asked(84, length));
    EXPECT_FALSE(asked(84.5, length));
    EXPECT_FALSE(asked(90, length));
    EXPECT_FALSE(asked(180, length));
  }
  p.min_facing = -0.5f;  // 120°
  EXPECT_TRUE(asked(119, 1.0f));
  EXPECT_FALSE(asked(121, 1.0f));
}

TEST(IsAsked, AtTheLeastCosineItselfToo) {
  ConsistencyParameters p;
  p.min_facing = 0.5f;
  EXPECT_TRUE(isAsked(p, {0, 0, 1}, {0, 0, 2}));
  p.min_facing = 1;
  EXPECT_TRUE(isAsked(p, {0, 0, 1}, {0, 0, 2}));
  EXPECT_FALSE(isAsked(p, {0, 0, 1}, {0, 0.01f, 2}));
  p.min_facing = 0;
  EXPECT_TRUE(isAsked(p, {0, 0, 1}, {1, 0, 0}));
}

TEST(IsAsked, EveryViewWhereTheNormalIsNotKnown) {
  ConsistencyParameters p;
  p.min_facing = 1;
  EXPECT_TRUE(isAsked(p, {}, {0, 0, 1}));
}

TEST(IsAsked, NormalsDoNotMatterToThePublishedFormNorWhereAllViewsAreWanted) {
  ConsistencyParameters p;
  EXPECT_TRUE(asksForNormals(p));
  p.occlusion = OcclusionForm::Published;
  EXPECT_FALSE(asksForNormals(p));
  p = {};
  p.min_facing = -1;
  EXPECT_FALSE(asksForNormals(p));
}

TEST(FacingNormal, IsTurnedToTheCameraThatMeasuredThePoint) {
  const auto expectNormal = [](const Vec3& n, float x, float y, float z) {
    EXPECT_EQ(n.x, x);
    EXPECT_EQ(n.y, y);
    EXPECT_EQ(n.z, z);
  };
  expectNormal(facingNormal({0, 1, 2}, {0, 0, 1}), 0, 1, 2);
  expectNormal(facingNormal({0, 1, 2}, {0, 0, -1}), 0, -1, -2);
  expectNormal(facingNormal({0, std::numeric_limits<float>::quiet_NaN(), 1}, {0, 0, 1}), 0, 0, 0);
}

TEST(ConsistencySigma, IsAtLeastTheNoiseOfTheMeasurement) {
  ConsistencyParameters p;
  p.sigma = 0.02f;
  p.sigma_per_noise = 2.0f;
  EXPECT_FLOAT_EQ(consistencySigma(p, 0.0f), 0.02f);
  EXPECT_FLOAT_EQ(consistencySigma(p, 0.009f), 0.02f);
  EXPECT_FLOAT_EQ(consistencySigma(p, 0.025f), 0.05f);
  p.sigma_per_noise = 0;
  EXPECT_FLOAT_EQ(consistencySigma(p, 1.0f), 0.02f);
}

TEST(ConsistencySigma, OfTheMeasuredDepthScalesTheDistance) {
  ConsistencyParameters p = form(OcclusionForm::OcclusionAware, DistanceForm::AlongRay);
  EXPECT_NEAR(viewOpinion(p, {0, 0, 2.05f}, {}, 2.0f, 0.05f).squared_distance, 1.0f, 1e-4f);
}

TEST(Consistency, IsOneWithoutAnyView) { EXPECT_EQ(V({}, {}), 1.0f); }

TEST(Consistency, IsOneOverEAtADistanceOfSigma) {
  EXPECT_FLOAT_EQ(V({}, {{ViewOpinion::Distance, 1.0f}}), std::exp(-1.0f));
}

TEST(Consistency, AveragesTheSquaredDistancesOfTheViews) {
  // (0 + 1 + 5) / 3 = 2.
  EXPECT_FLOAT_EQ(V({}, {{ViewOpinion::Distance, 0.0f}, {ViewOpinion::Distance, 1.0f}, {ViewOpinion::Distance, 5.0f}}),
                  std::exp(-2.0f));
}

TEST(Consistency, SkipsViewsThatThePointIsHiddenFrom) {
  EXPECT_EQ(V({}, {{ViewOpinion::Hidden, 0.0f}}), 1.0f);
  EXPECT_FLOAT_EQ(V({}, {{ViewOpinion::Hidden, 0.0f}, {ViewOpinion::Distance, 1.0f}}), std::exp(-1.0f));
  Consistency c;
  c.add({}, {ViewOpinion::Hidden, 0.0f});
  EXPECT_EQ(c.views(), 0);
}

TEST(Consistency, PenalisesEachViewThatHasSeenThroughHoweverManyAgree) {
  ConsistencyParameters p;
  p.free_space_penalty = 0.25f;
  EXPECT_FLOAT_EQ(V(p, {{ViewOpinion::SeenThrough, 0.0f}}), 0.25f);
  EXPECT_FLOAT_EQ(V(p, {{ViewOpinion::SeenThrough, 0.0f}, {ViewOpinion::SeenThrough, 0.0f}}), 0.0625f);
  EXPECT_FLOAT_EQ(V(p, {{ViewOpinion::SeenThrough, 0.0f},
                        {ViewOpinion::Distance, 1.0f},
                        {ViewOpinion::Distance, 1.0f},
                        {ViewOpinion::Distance, 1.0f}}),
                  0.25f * std::exp(-1.0f));
}

/** \brief Two cameras side by side, 0.4 m apart, facing a wall at z = 2 m. */
class TwoCamerasFacingAWall : public ::testing::Test {
 protected:
  TwoCamerasFacingAWall() {
    for (int i = 0; i < 2; ++i) {
      Camera camera;
      camera.name = i == 0 ? "left" : "right";
      camera.intrinsics.width = 41;
      camera.intrinsics.height = 31;
      camera.intrinsics.fx = camera.intrinsics.fy = 40;
      camera.intrinsics.cx = 20;
      camera.intrinsics.cy = 15;
      camera.T_world_camera.translation().x() = 0.4 * i;
      frame.cameras.push_back(camera);
      DepthView view;
      view.depth32 = {wall.data(), 41, 31};
      frame.views.push_back(view);
    }
    parameters.sigma = 0.02f;
  }

  /** \brief V of one point. */
  float V(float x, float y, float z, int source = 0) {
    const auto cloud = std::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
    cloud->push_back({x, y, z});
    MultiViewConsistency<pcl::PointXYZ> filter;
    filter.setFrame(frame, source);
    filter.setParameters(parameters);
    filter.setInputCloud(cloud);
    pcl::Indices kept;
    filter.filter(kept);
    views = filter.getViewCounts().at(0);
    return filter.getConsistency().at(0);
  }

  /** \brief V of (0.1, 0.05, 1.5) on a surface with a normal. */
  float VWithNormal(const std::array<float, 3>& normal, int source) {
    const auto cloud = std::make_shared<pcl::PointCloud<pcl::PointNormal>>();
    const Eigen::Vector3f p = (world * Eigen::Vector3d(0.1, 0.05, 1.5)).cast<float>();
    const Eigen::Vector3f n = world.linear().cast<float>() * Eigen::Vector3f(normal[0], normal[1], normal[2]);
    cloud->push_back({p.x(), p.y(), p.z(), n.x(), n.y(), n.z()});
    MultiViewConsistency<pcl::PointNormal> filter;
    filter.setFrame(frame, source);
    filter.setParameters(parameters);
    filter.setInputCloud(cloud);
    pcl::Indices kept;
    filter.filter(kept);
    views = filter.getViewCounts().at(0);
    return filter.getConsistency().at(0);
  }

  const std::vector<float> wall = std::vector<float>(41 * 31, 2.0f);
  RigFrame frame;
  ConsistencyParameters parameters;
  Eigen::Isometry3d world = Eigen::Isometry3d::Identity();
  int views{-1};
};

TEST_F(TwoCamerasFacingAWall, APointOnTheWallIsFullyConsistent) {
  EXPECT_NEAR(V(0.1f, 0.05f, 2.0f), 1.0f, 1e-5f);
  EXPECT_EQ(views, 1);
}

TEST_F(TwoCamerasFacingAWall, APointOneSigmaOffTheWallHasOneOverE) {
  EXPECT_NEAR(V(0.1f, 0.05f, 2.02f), std::exp(-1.0f), 1e-4f);
  EXPECT_EQ(views, 1);
  EXPECT_NEAR(V(0.1f, 0.05f, 1.98f), std::exp(-1.0f), 1e-4f);
  EXPECT_EQ(views, 1);
}

TEST_F(TwoCamerasFacingAWall, APointFarBehindTheWallIsHiddenAndNobodyJudgesIt) {
  EXPECT_EQ(V(0.1f, 0.05f, 3.0f), 1.0f);
  EXPECT_EQ(views, 0);
}

TEST_F(TwoCamerasFacingAWall, APointFarBeforeTheWallIsSeenThrough) {
  EXPECT_FLOAT_EQ(V(0.1f, 0.05f, 1.5f), parameters.free_space_penalty);
  EXPECT_EQ(views, 1);
}

TEST_F(TwoCamerasFacingAWall, APointOutsideTheOtherImageIsJudgedByNobody) {
  // The right image reaches from x = 0.4 − 2 · 20.5/40 = −0.625 at the wall.
  EXPECT_EQ(V(-0.7f, 0, 1.5f), 1.0f);
  EXPECT_EQ(views, 0);
}

TEST_F(TwoCamerasFacingAWall, APointBehindTheCamerasIsJudgedByNobody) {
  EXPECT_EQ(V(0.1f, 0, -2.0f), 1.0f);
  EXPECT_EQ(views, 0);
}

TEST_F(TwoCamerasFacingAWall, WithoutASourceCameraAllViewsAreAsked) {
  EXPECT_NEAR(V(0.1f, 0.05f, 2.02f, -1), std::exp(-1.0f), 1e-4f);
  EXPECT_EQ(views, 2);
  EXPECT_FLOAT_EQ(V(0.1f, 0.05f, 1.5f, -1), parameters.free_space_penalty * parameters.free_space_penalty);
}

TEST_F(TwoCamerasFacingAWall, AViewThatTheSurfaceFacesAwayFromIsNotAsked) {
  // 1.5 m, before the wall: both cameras have seen through it, unless it is a surface's back, which they cannot see.
  const float once = parameters.free_space_penalty;
  const std::array<float, 3> towards{0, 0, -1}, away{0, 0, 1}, none{0, 0, 0};
  EXPECT_FLOAT_EQ(VWithNormal(none, 0), once);
  EXPECT_FLOAT_EQ(VWithNormal({0, std::numeric_limits<float>::quiet_NaN(), 1}, 0), once);
  // Of no camera: the normal may be that of the other side.
  for (const auto& normal : {towards, away}) {
    EXPECT_FLOAT_EQ(VWithNormal(normal, -1), once * once);
    EXPECT_EQ(views, 2);
  }
  // Camera 0 has measured it, so its surface faces camera 0, whatever the sign of the normal.
  EXPECT_FLOAT_EQ(VWithNormal(towards, 0), once);
  EXPECT_FLOAT_EQ(VWithNormal(away, 0), once);
  // Across: camera 1 stands at x = 0.4, which a surface does not see that faces −x.
  EXPECT_EQ(VWithNormal({-1, 0, 0}, 0), 1.0f);
  EXPECT_EQ(views, 0);
  parameters.min_facing = -1;
  EXPECT_FLOAT_EQ(VWithNormal({-1, 0, 0}, 0), once);
}

TEST_F(TwoCamerasFacingAWall, WhereASurfaceFacesMovesWithTheWorld) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.rotate(Eigen::AngleAxisd(2.1, Eigen::Vector3d(1, -2, 0.5).normalized()));
  T.translation() << 3, -1, 2;
  const std::array<std::array<float, 3>, 3> normals{{{-1, 0, 0}, {0, 0, -1}, {1, 0, 1}}};
  std::vector<float> before, after;
  for (const auto& normal : normals) before.push_back(VWithNormal(normal, 0));
  for (Camera& camera : frame.cameras) camera.T_world_camera = T * camera.T_world_camera;
  world = T;
  for (const auto& normal : normals) after.push_back(VWithNormal(normal, 0));
  EXPECT_EQ(before[0], 1.0f);
  for (std::size_t k = 0; k < normals.size(); ++k) EXPECT_FLOAT_EQ(after[k], before[k]);
}

TEST_F(TwoCamerasFacingAWall, ThePixelsOfASlantedSurfaceAreNoEdge) {
  // 55 mm before what is measured in the middle of the right image. Two columns away the wall is nearer to the point, too.
  const float once = parameters.free_space_penalty;
  std::vector<float> slanted = wall;
  frame.views[1].depth32 = {slanted.data(), 41, 31};
  float& beside = slanted[15 * 41 + 18];
  beside = 1.97f;
  EXPECT_FLOAT_EQ(V(0.4f, 0, 1.945f), once);
  beside = 1.94f;  // 60 mm are an edge
  EXPECT_EQ(V(0.4f, 0, 1.945f), 1.0f);
}

TEST_F(TwoCamerasFacingAWall, AViewThatHasMeasuredThePointsSurfaceBesideItSaysNothing) {
  // (0.4, 0, 1.5) falls onto the middle of the right image, (20, 15), where that has seen the wall at 2 m.
  const float once = parameters.free_space_penalty;
  EXPECT_FLOAT_EQ(V(0.4f, 0, 1.5f), once);
  std::vector<float> edge = wall;
  frame.views[1].depth32 = {edge.data(), 41, 31};
  for (const int du : {-2, 2})
    for (const int dv : {-2, 0, 1, 2}) {
      float& there = edge[static_cast<std::size_t>((15 + dv) * 41 + 20 + du)];
      for (const float depth : {1.451f, 1.5f, 1.549f}) {  // margin · sigma is 50 mm
        there = depth;
        parameters.silhouette_radius = 2;
        EXPECT_EQ(V(0.4f, 0, 1.5f), 1.0f) << du << ' ' << dv << ' ' << depth;
        EXPECT_EQ(views, 0);
        parameters.silhouette_radius = 1;  // two pixels away
        EXPECT_FLOAT_EQ(V(0.4f, 0, 1.5f), once);
        parameters.silhouette_radius = 0;
        EXPECT_FLOAT_EQ(V(0.4f, 0, 1.5f), once);
      }
      parameters.silhouette_radius = 2;
      for (const float depth : {1.449f, 1.551f, 0.0f}) {  // of another surface, or none
        there = depth;
        EXPECT_FLOAT_EQ(V(0.4f, 0, 1.5f), once) << du << ' ' << dv << ' ' << depth;
      }
      there = 2;
    }
}

TEST_F(TwoCamerasFacingAWall, BesideTheBorderOfAnImageThereIsNothing) {
  // (0.4 + 1.5 · 20/40, 1.5 · 15/40, 1.5) falls onto the last pixel of the right image.
  parameters.silhouette_radius = kMaxSilhouetteRadius;
  EXPECT_FLOAT_EQ(V(1.15f, 0.5625f, 1.5f), parameters.free_space_penalty);
  EXPECT_EQ(views, 1);
}

TEST_F(TwoCamerasFacingAWall, AsPublishedAViewBehindCountsToo) {
  parameters.occlusion = OcclusionForm::Published;
  EXPECT_LT(VWithNormal({-1, 0, 0}, 0), 1e-6f);
  EXPECT_EQ(views, 1);
}

TEST_F(TwoCamerasFacingAWall, AMissingViewSaysNothing) {
  frame.views[1] = {};
  EXPECT_EQ(V(0.1f, 0.05f, 1.5f), 1.0f);
  EXPECT_EQ(views, 0);
}

TEST_F(TwoCamerasFacingAWall, AHoleInTheOtherDepthImageSaysNothing) {
  const std::vector<float> holes(41 * 31, 0.0f);
  frame.views[1].depth32 = {holes.data(), 41, 31};
  EXPECT_EQ(V(0.1f, 0.05f, 1.5f), 1.0f);
  EXPECT_EQ(views, 0);
}

TEST_F(TwoCamerasFacingAWall, AsPublishedAPointBehindTheWallIsPunishedForBeingHidden) {
  parameters.occlusion = OcclusionForm::Published;
  EXPECT_NEAR(V(0.1f, 0.05f, 2.06f), std::exp(-9.0f), 1e-6f);  // 3 σ
  EXPECT_EQ(views, 1);
}

TEST_F(TwoCamerasFacingAWall, TheEuclideanDistanceFallsBackToTheDepthDifferenceAtAPixelCentre) {
  parameters.distance = DistanceForm::Euclidean;
  // On the right camera's optical axis: Q = (0.4, 0, 2), nothing is sideways.
  EXPECT_NEAR(V(0.4f, 0, 2.02f), std::exp(-1.0f), 1e-4f);
  // 15 mm sideways still falls on that pixel, whose neighbours are 50 mm off: d² = 20² + 15².
  EXPECT_NEAR(V(0.415f, 0, 2.02f), std::exp(-625.0f / 400.0f), 1e-4f);
}

TEST_F(TwoCamerasFacingAWall, ARigidMotionOfTheWholeSceneChangesNothing) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  T.translation() << 3, -2, 1;
  for (Camera& camera : frame.cameras) camera.T_world_camera = T * camera.T_world_camera;
  const Eigen::Vector3f p = (T * Eigen::Vector3d(0.1, 0.05, 2.02)).cast<float>();
  EXPECT_NEAR(V(p.x(), p.y(), p.z()), std::exp(-1.0f), 1e-3f);
}

TEST_F(TwoCamerasFacingAWall, NoMoreThanTheAllowedNumberOfOtherViewsIsAsked) {
  frame.cameras.push_back(frame.cameras[1]);
  frame.views.push_back(frame.views[1]);
  V(0.1f, 0.05f, 2.0f);
  EXPECT_EQ(views, 2);
  parameters.max_views = 2;
  V(0.1f, 0.05f, 2.0f);
  EXPECT_EQ(views, 1);
}

}  // namespace
