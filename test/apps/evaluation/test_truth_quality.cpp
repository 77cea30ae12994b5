#include "../simulation/mesh_checks.h"

#include "evaluation/truth_quality.h"
#include "simulation/rig_layout.h"
#include "simulation/sensor.h"

#include <cmath>

namespace {

using namespace fuse_flow::simulation;
using mesh_checks::Vector3f;

/** \brief A square of 1 m², seen whole by a camera 2 m above it. */
class TruthQualityOfASquare : public testing::Test {
 protected:
  TruthQualityOfASquare() {
    scene.setFixed({mesh_checks::squareFacingUp(0.5f, 0)});
    fuse_flow::Camera camera;
    camera.intrinsics = {640, 480, 525, 525, 319.5f, 239.5f, {}};
    camera.T_world_camera = lookAt({0, 0, 2}, {0, 0, 0});
    cameras = {camera};
    visible = visibleSurface(scene, cameras, {true}, Visibility(), 2);
    for (const SurfacePoint& point : visible) surface.positions.push_back(point.position);
  }

  PlainCloud shifted(const Vector3f& by) const {
    PlainCloud cloud = surface;
    for (Vector3f& p : cloud.positions) p += by;
    return cloud;
  }
  TruthQuality quality(const PlainCloud& cloud) const { return compareWithTruth(cloud, scene, visible, 2); }

  RayScene scene;
  std::vector<fuse_flow::Camera> cameras;
  std::vector<SurfacePoint> visible;
  PlainCloud surface;
};

TEST_F(TruthQualityOfASquare, SamplesWhatIsSeenEvenly) {
  EXPECT_NEAR(static_cast<double>(visible.size()), 1 / (0.015 * 0.015), 50);
  std::size_t quarter = 0;
  for (const SurfacePoint& point : visible) quarter += point.position.x() > 0 && point.position.y() > 0 ? 1 : 0;
  EXPECT_NEAR(static_cast<double>(quarter) / static_cast<double>(visible.size()), 0.25, 0.03);
}

TEST_F(TruthQualityOfASquare, SamplesNothingThatNoCameraSees) {
  EXPECT_TRUE(visibleSurface(scene, cameras, {false}, Visibility(), 2).empty());
  Visibility near_only;
  near_only.max_range = 1.9f;
  EXPECT_TRUE(visibleSurface(scene, cameras, {true}, near_only, 2).empty());
  cameras[0].T_world_camera = lookAt({0, 0, -2}, {0, 0, 0});
  EXPECT_TRUE(visibleSurface(scene, cameras, {true}, Visibility(), 2).empty()) << "from behind";
  RayScene covered;
  covered.setFixed({mesh_checks::squareFacingUp(0.5f, 0), mesh_checks::squareFacingUp(0.25f, 1)});
  cameras[0].T_world_camera = lookAt({0, 0, 2}, {0, 0, 0});
  for (const SurfacePoint& point : visibleSurface(covered, cameras, {true}, Visibility(), 2))
    EXPECT_EQ(point.object, 1u);
}

TEST_F(TruthQualityOfASquare, IsPerfectForTheSurfaceItself) {
  const TruthQuality q = quality(surface);
  EXPECT_EQ(q.points, surface.positions.size());
  EXPECT_EQ(q.surface_samples, visible.size());
  EXPECT_NEAR(q.accuracy_mean, 0, 1e-4);
  EXPECT_NEAR(q.accuracy_p95, 0, 1e-4);
  EXPECT_EQ(q.precision_5, 1);
  EXPECT_EQ(q.completeness_5, 1);
  EXPECT_EQ(q.f_score_5, 1);
  EXPECT_EQ(q.f_score_10, 1);
  EXPECT_EQ(q.ghosting, 0);
  EXPECT_TRUE(std::isnan(q.normal_error)) << "the cloud has no normals";
  EXPECT_TRUE(std::isnan(q.color_error));
}

TEST_F(TruthQualityOfASquare, OfACloudSevenMillimetresOffIsThatFar) {
  const TruthQuality q = quality(shifted({0, 0, 0.007f}));
  EXPECT_NEAR(q.accuracy_mean, 7, 1e-3);
  EXPECT_NEAR(q.accuracy_median, 7, 1e-3);
  EXPECT_EQ(q.precision_5, 0);
  EXPECT_EQ(q.precision_10, 1);
  EXPECT_EQ(q.completeness_5, 0);
  EXPECT_EQ(q.completeness_10, 1);
  EXPECT_EQ(q.f_score_5, 0);
  EXPECT_EQ(q.f_score_10, 1);
  EXPECT_EQ(q.ghosting, 0);
}

TEST_F(TruthQualityOfASquare, OfHalfOfTheSurfaceIsHalfComplete) {
  PlainCloud half;
  for (const Vector3f& p : surface.positions)
    if (p.x() < 0) half.positions.push_back(p);
  const TruthQuality q = quality(half);
  EXPECT_EQ(q.precision_5, 1);
  EXPECT_NEAR(q.completeness_5, 0.5, 0.03);
  EXPECT_NEAR(q.f_score_5, 2.0 / 3, 0.03);
}

TEST_F(TruthQualityOfASquare, CountsPointsFarFromAnySurfaceAsGhosts) {
  PlainCloud cloud = surface;
  const PlainCloud ghosts = shifted({0, 0, 0.05f});
  cloud.positions.insert(cloud.positions.end(), ghosts.positions.begin(), ghosts.positions.end());
  const TruthQuality q = quality(cloud);
  EXPECT_DOUBLE_EQ(q.ghosting, 0.5);
  EXPECT_DOUBLE_EQ(q.precision_10, 0.5);
  EXPECT_EQ(q.completeness_5, 1);
}

TEST_F(TruthQualityOfASquare, ComparesNormalsAndColours) {
  PlainCloud cloud = surface;
  const Vector3f tilted(std::sin(0.2f), 0, std::cos(0.2f));
  cloud.normals.assign(cloud.positions.size(), tilted);
  const Vector3f color = litColor(Material(), Vector3f::UnitZ(), Vector3f::Zero());
  cloud.colors.assign(cloud.positions.size(), color + Vector3f(3, -6, 0));
  const TruthQuality q = quality(cloud);
  EXPECT_NEAR(q.normal_error, 0.2 * 57.29578, 0.01);
  EXPECT_NEAR(q.color_error, 3, 1e-3);
}

TEST_F(TruthQualityOfASquare, ACloudHoweverFarAwayCoversNothing) {
  for (const float far : {1e3f, 1e12f, 1e20f, 1e38f}) {
    const TruthQuality q = quality(shifted({0, far, 0}));
    EXPECT_EQ(q.completeness_10, 0) << far;
    EXPECT_EQ(q.precision_10, 0) << far;
    EXPECT_EQ(q.ghosting, 1) << far;
  }
}

TEST_F(TruthQualityOfASquare, OfAnEmptyCloudCannotBeSaid) {
  const TruthQuality q = quality(PlainCloud());
  EXPECT_EQ(q.points, 0u);
  EXPECT_TRUE(std::isnan(q.accuracy_mean));
  EXPECT_EQ(q.completeness_10, 0);
}

TEST_F(TruthQualityOfASquare, FlickerIsTheChangeFromFrameToFrame) {
  EXPECT_NEAR(flicker(surface, surface, scene, 2), 0, 1e-6);
  EXPECT_NEAR(flicker(surface, shifted({0, 0, 0.003f}), scene, 2), 3, 1e-3);
  EXPECT_NEAR(flicker(shifted({0, 0, -0.001f}), shifted({0, 0, 0.003f}), scene, 2), 4, 1e-3)
      << "from one side to the other";
  EXPECT_NEAR(flicker(surface, shifted({0.004f, 0, 0}), scene, 2), 0, 0.2) << "other points of the same surface";
  EXPECT_NEAR(flicker(surface, {}, scene, 2), 30, 1e-3) << "points that vanish";
  RayScene moving;
  moving.setMoving({mesh_checks::squareFacingUp(0.5f, 0)});
  EXPECT_TRUE(std::isnan(flicker(surface, surface, moving, 2))) << "what moves does not flicker";
}

}  // namespace
