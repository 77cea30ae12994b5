#include "mesh_checks.h"

#include "simulation/ray_scene.h"
#include "simulation/shapes.h"

#include <cmath>

namespace {

using namespace fuse_flow::simulation;
using mesh_checks::squareFacingUp;
using mesh_checks::Vector3f;

RayScene sceneOf(const std::vector<Object>& fixed, const std::vector<Object>& moving = {}) {
  RayScene scene;
  scene.setFixed(fixed);
  scene.setMoving(moving);
  return scene;
}

Object ballAt(const Vector3f& centre, float radius) { return {"ball", moved(sphere(radius), centre), {}}; }

TEST(RayScene, MeetsASphereWhereTheRayEntersIt) {
  const RayScene scene = sceneOf({ballAt({0, 0, 2}, 0.5f)});
  const RayHit hit = scene.intersect({0.1f, 0.2f, 0}, {0, 0, 1});
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit.t, 2 - std::sqrt(0.25f - 0.05f), 3e-4f);
  EXPECT_LT((hit.normal - (hit.position - Vector3f(0, 0, 2)).normalized()).norm(), 5e-3f);
  EXPECT_FALSE(scene.intersect({0.6f, 0, 0}, {0, 0, 1}));
}

TEST(RayScene, MeasuresAlongARayInLengthsOfItsDirection) {
  const RayScene scene = sceneOf({squareFacingUp(1, 0)});
  EXPECT_NEAR(scene.intersect({0.3f, 0.1f, 2}, {0, 0, -0.5f}).t, 4, 1e-5f);
}

TEST(RayScene, SeesASurfaceFromBothSides) {
  const RayScene scene = sceneOf({squareFacingUp(1, 0)});
  const RayHit above = scene.intersect({0.3f, 0.1f, 2}, {0, 0, -1}),
               below = scene.intersect({0.3f, 0.1f, -3}, {0, 0, 1});
  EXPECT_NEAR(above.t, 2, 1e-5f);
  EXPECT_NEAR(below.t, 3, 1e-5f);
  EXPECT_TRUE(above.normal.isApprox(Vector3f::UnitZ(), 1e-6f));
  EXPECT_TRUE(below.normal.isApprox(Vector3f::UnitZ(), 1e-6f));
}

TEST(RayScene, FindsTheNearestPointOfFaceEdgeAndCorner) {
  const RayScene scene = sceneOf({squareFacingUp(1, 0)});
  const auto expectNearest = [&](const Vector3f& from, const Vector3f& to) {
    const RayHit hit = scene.nearest(from);
    EXPECT_TRUE(hit.position.isApprox(to, 1e-5f)) << hit.position.transpose();
    EXPECT_NEAR(hit.t, (from - to).norm(), 1e-5f);
  };
  expectNearest({0.3f, -0.4f, 0.7f}, {0.3f, -0.4f, 0});
  expectNearest({1.5f, 0.2f, 0.5f}, {1, 0.2f, 0});
  expectNearest({2, -3, 1}, {1, -1, 0});
}

TEST(RayScene, FindsTheNearestOfSeveralObjectsWithinARadius) {
  const RayScene scene = sceneOf({squareFacingUp(5, 0), ballAt({0, 0, 2}, 0.5f)});
  const RayHit hit = scene.nearest({0, 0, 1.2f});
  EXPECT_EQ(scene.object(hit.object).name, "ball");
  EXPECT_NEAR(hit.t, 0.3f, 3e-4f);
  EXPECT_FALSE(scene.nearest({0, 0, 1.2f}, 0.25f));
  EXPECT_TRUE(scene.nearest({0, 0, 1.2f}, 0.35f));
}

TEST(RayScene, KnowsWhatStandsBetweenTwoPoints) {
  const RayScene scene = sceneOf({ballAt({0, 0, 1}, 0.2f)});
  EXPECT_TRUE(scene.occluded({0, 0, 0}, {0, 0, 2}));
  EXPECT_FALSE(scene.occluded({0.3f, 0, 0}, {0.3f, 0, 2}));
  EXPECT_FALSE(scene.occluded({0, 0, 0}, {0, 0, 0.8f})) << "a point of the surface is not hidden by itself";
}

TEST(RayScene, ReplacesWhatMovesAndKeepsWhatDoesNot) {
  RayScene scene = sceneOf({squareFacingUp(5, 0)}, {ballAt({0, 0, 1}, 0.2f)});
  EXPECT_TRUE(scene.moving(1));
  EXPECT_FALSE(scene.moving(0));
  EXPECT_NEAR(scene.intersect({0, 0, 3}, {0, 0, -1}).t, 1.8f, 1e-4f);
  scene.setMoving({ballAt({2, 0, 1}, 0.2f)});
  EXPECT_NEAR(scene.intersect({0, 0, 3}, {0, 0, -1}).t, 3, 1e-4f);
  EXPECT_NEAR(scene.intersect({2, 0, 3}, {0, 0, -1}).t, 1.8f, 1e-4f);
  EXPECT_EQ(scene.objectCount(), 2u);
}

TEST(RayScene, TellsWhereAPointWasAtRest) {
  Object square = squareFacingUp(1, 0);
  square.mesh.rest = square.mesh.vertices;
  for (Vector3f& v : square.mesh.vertices) v += Vector3f(3, 0, 1);
  EXPECT_TRUE(sceneOf({square}).intersect({3.25f, 0.5f, 4}, {0, 0, -1}).rest.isApprox(Vector3f(0.25f, 0.5f, 0), 1e-5f));
}

}  // namespace
