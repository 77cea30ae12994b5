#include "mesh_checks.h"

#include "simulation/surfaces/ray_scene.h"
#include "simulation/surfaces/shapes.h"

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

Object cubeFrom(const TriangleMesh& mesh) { return {"cube", mesh, {}}; }

/** \brief With the inside out: the walls of a room. */
TriangleMesh turnedInside(TriangleMesh mesh) {
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  for (Vector3f& n : mesh.normals) n = -n;
  return mesh;
}

TEST(RayScene, TellsTheSideOfASurfaceAtItsEdgesAndCornersToo) {
  TriangleMesh cube = box({1, 1, 1});
  // Cut along the other diagonal: of its corners' three faces some then have one triangle there and some two.
  cube.triangles[0] = {0, 1, 3};
  cube.triangles[1] = {1, 2, 3};
  const RayScene solid = sceneOf({cubeFrom(cube)}), room = sceneOf({cubeFrom(turnedInside(cube))});
  const auto expectSide = [](const RayScene& scene, const Vector3f& at, float signed_distance, const Vector3f& normal) {
    const NearestHit hit = scene.nearest(at);
    EXPECT_NEAR(hit.signed_distance, signed_distance, 1e-6f) << at.transpose();
    EXPECT_EQ(hit.t, std::fabs(hit.signed_distance));
    EXPECT_LT((hit.normal - normal.normalized()).norm(), 1e-6f) << at.transpose();
  };
  for (const float x : {-1.0f, 1.0f})
    for (const float y : {-1.0f, 1.0f})
      for (const float z : {-1.0f, 1.0f}) {
        const Vector3f corner(x, y, z), edge(x, y, 0), face(x, 0, 0);
        expectSide(solid, 0.6f * corner, 0.1f * std::sqrt(3.0f), corner);
        expectSide(solid, 0.6f * edge, 0.1f * std::sqrt(2.0f), edge);
        expectSide(solid, 0.6f * face + Vector3f(0, 0.1f, 0.2f), 0.1f, face);
        expectSide(solid, 0.4f * face + Vector3f(0, 0.1f, 0.2f), -0.1f, face);
        expectSide(room, 0.6f * corner, -0.1f * std::sqrt(3.0f), -corner);
        expectSide(room, 0.6f * edge, -0.1f * std::sqrt(2.0f), -edge);
        expectSide(room, 0.4f * face + Vector3f(0, 0.1f, 0.2f), 0.1f, -face);
        // Away from the diagonal of a corner, where only one of its triangles may be asked.
        EXPECT_GT(solid.nearest(0.5f * corner + 0.01f * Vector3f(x, 3 * y, 9 * z)).signed_distance, 0);
        EXPECT_LT(room.nearest(0.5f * corner + 0.01f * Vector3f(x, 3 * y, 9 * z)).signed_distance, 0);
      }
}

/** \brief The shade of the room's lamp: a shell of 4 mm whose walls lean, so that at its lower rim they make less than a right
 *  angle, and what is straight below the rim lies behind the outer wall's plane. */
TEST(RayScene, TellsTheSideOfAThinRim) {
  const TriangleMesh shade = lathe({{{0.2f, 1.45f}, {0.14f, 1.7f}},
                                    {{0.14f, 1.7f}, {0.136f, 1.7f}},
                                    {{0.136f, 1.7f}, {0.196f, 1.45f}},
                                    {{0.196f, 1.45f}, {0.2f, 1.45f}}});
  const RayScene scene = sceneOf({{"shade", shade, {}}});
  int rim = 0;
  for (const Vector3f& v : shade.vertices) {
    const Vector3f out = Vector3f(v.x(), v.y(), 0).normalized();
    if (v.z() == 1.45f && v.head<2>().norm() > 0.198f) {
      ++rim;
      EXPECT_NEAR(scene.nearest(v + 0.25f * (0.05f * out - 0.99875f * Vector3f::UnitZ())).signed_distance, 0.25f,
                  1e-5f);
      EXPECT_NEAR(scene.nearest(v + 0.25f * (0.9f * out - 0.43589f * Vector3f::UnitZ())).signed_distance, 0.25f, 1e-5f);
    }
  }
  EXPECT_GT(rim, 40);
  for (float angle = 0; angle < 6.2f; angle += 0.1f) {
    const Vector3f out(std::cos(angle), std::sin(angle), 0), up(0, 0, 1.575f);
    EXPECT_NEAR(scene.nearest(0.168f * out + up).signed_distance, -0.002f, 2e-4f) << "within the shell";
    EXPECT_GT(scene.nearest(0.160f * out + up).signed_distance, 0) << "inside the shade, in front of the shell";
    EXPECT_GT(scene.nearest(0.176f * out + up).signed_distance, 0);
  }
}

TEST(RayScene, LetsNoRayThroughAnEdgeOrAVertexOfAClosedMesh) {
  for (const TriangleMesh& mesh : {sphere(0.5f), box({0.3f, 0.5f, 0.7f}), roundedBox({0.4f, 0.4f, 0.6f}, 0.07f)}) {
    const RayScene scene = sceneOf({cubeFrom(mesh)});
    for (const Vector3f& from : {Vector3f(0, 0, 0), Vector3f(0.03f, -0.05f, 0.11f), Vector3f(0.125f, 0.125f, -0.25f)}) {
      for (const auto& t : mesh.triangles)
        for (int k = 0; k < 3; ++k) {
          const Vector3f &a = mesh.vertices[t[static_cast<std::size_t>(k)]], &b = mesh.vertices[t[(k + 1) % 3]];
          for (const float part : {0.0f, 0.5f, 0.3f}) {
            const Vector3f on = a + part * (b - a);
            const RayHit hit = scene.intersect(from, on - from);
            ASSERT_TRUE(hit) << from.transpose() << " to " << on.transpose();
            ASSERT_NEAR(hit.t, 1, 2e-3f);
            ASSERT_TRUE(scene.intersect(on + (on - from), from - on));
            ASSERT_TRUE(scene.occluded(from, on + (on - from)));
          }
        }
    }
  }
}

TEST(RayScene, MeetsNothingOfATriangleSeenEdgeOnOrOfOneWithoutArea) {
  const RayScene square = sceneOf({squareFacingUp(1, 0)});
  EXPECT_FALSE(square.intersect({-3, 0.2f, 0}, {1, 0, 0}));
  Object needle = squareFacingUp(1, 0);
  needle.mesh.vertices[2] = needle.mesh.vertices[3] = needle.mesh.vertices[1];
  const RayScene none = sceneOf({needle});
  EXPECT_FALSE(none.intersect({0, -1, 3}, {0, 0, -1}));
  EXPECT_NEAR(none.nearest({0, -1, 3}).t, 3, 1e-6f);
  EXPECT_FALSE(sceneOf({}).intersect({0, 0, 0}, {0, 0, 1}));
  EXPECT_FALSE(sceneOf({}).nearest({0, 0, 0}));
}

}  // namespace
