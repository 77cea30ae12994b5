#include "mesh_checks.h"

#include "simulation/scenes/tableware.h"
#include "simulation/surfaces/implicit_surface.h"
#include "simulation/surfaces/shapes.h"

#include <algorithm>

namespace {

using namespace fuse_flow::simulation;
using mesh_checks::Vector3d;
using mesh_checks::Vector3f;

constexpr double kPi = 3.14159265358979323846;

void expectSolid(const TriangleMesh& mesh, const std::string& name) {
  EXPECT_TRUE(mesh_checks::allFinite(mesh)) << name;
  EXPECT_TRUE(mesh_checks::unitNormals(mesh)) << name;
  EXPECT_EQ(mesh_checks::openEdges({&mesh}), 0u) << name;
  EXPECT_GT(mesh_checks::volume(mesh), 0) << name;
  EXPECT_EQ(mesh_checks::backwardNormals(mesh), 0) << name;
}

TEST(Shapes, AreClosedAndTurnOutwards) {
  expectSolid(box({0.1f, 0.2f, 0.3f}), "box");
  expectSolid(roundedBox({0.4f, 0.3f, 0.2f}, 0.03f), "rounded box");
  expectSolid(sphere(0.1f), "sphere");
  expectSolid(ellipsoid({0.1f, 0.05f, 0.02f}), "ellipsoid");
  expectSolid(cylinder(0.05f, 0.03f, 0.2f), "cylinder");
  expectSolid(cylinder(0.05f, 0, 0.2f), "cone");
  expectSolid(torus(0.1f, 0.02f), "torus");
  expectSolid(tube({{0, 0, 0}, {0.1f, 0, 0}, {0.2f, 0.05f, 0}}, 0.01f), "tube");
  expectSolid(extrude({{0.1f, 0}, {0, 0.1f}, {-0.1f, 0}, {0, -0.1f}}, 0.05f), "prism");
  expectSolid(bowl(0.08f, 0.004f), "bowl");
  expectSolid(cup(0.04f, 0.09f, 0.004f), "cup");
  expectSolid(bottle(0.035f, 0.2f), "bottle");
  expectSolid(gear(0.05f, 0.02f, 12), "gear");
  expectSolid(duck(0.12f), "duck");
}

TEST(Shapes, HaveTheVolumesOfTheirFormulas) {
  EXPECT_NEAR(mesh_checks::volume(box({0.1f, 0.2f, 0.3f})), 0.006, 1e-8);
  EXPECT_NEAR(mesh_checks::volume(sphere(0.1f)) / (4.0 / 3 * kPi * 1e-3), 1, 0.005);
  EXPECT_NEAR(mesh_checks::volume(cylinder(0.05f, 0.05f, 0.2f)) / (kPi * 0.0025 * 0.2), 1, 0.005);
  EXPECT_NEAR(mesh_checks::volume(torus(0.1f, 0.02f)) / (2 * kPi * kPi * 0.1 * 0.0004), 1, 0.02);
  EXPECT_NEAR(mesh_checks::volume(ellipsoid({0.1f, 0.05f, 0.02f})) / (4.0 / 3 * kPi * 1e-4), 1, 0.005);
  EXPECT_NEAR(mesh_checks::volume(extrude({{0.1f, 0}, {0, 0.1f}, {-0.1f, 0}, {0, -0.1f}}, 0.05f)), 0.02 * 0.05, 1e-8);
}

TEST(Shapes, OfRoundThingsLieWithinATenthOfAMillimetre) {
  const TriangleMesh ball = sphere(0.12f);
  for (const auto& t : ball.triangles) {
    const Vector3f middle = (ball.vertices[t[0]] + ball.vertices[t[1]] + ball.vertices[t[2]]) / 3;
    ASSERT_NEAR(middle.norm(), 0.12f, 2e-4f);
  }
  for (std::size_t k = 0; k < ball.vertices.size(); ++k)
    ASSERT_GT(ball.normals[k].dot(ball.vertices[k].normalized()), 0.9999f);
  const TriangleMesh rounded = roundedBox({0.4f, 0.3f, 0.2f}, 0.03f);
  for (const Vector3f& v : rounded.vertices) {
    const Vector3f out = (v.cwiseAbs() - Vector3f(0.17f, 0.12f, 0.07f)).cwiseMax(0.0f);
    ASSERT_NEAR(out.norm(), 0.03f, 1e-6f);
  }
}

TEST(ImplicitSurface, HasItsVerticesExactlyOnTheBody) {
  const ImplicitBody ball = [](const Vector3d& p) { return p.norm() - 0.1; };
  const TriangleMesh mesh = polygonise(ball, {Vector3d::Constant(-0.13), Vector3d::Constant(0.13)}, 0.01);
  expectSolid(mesh, "ball");
  for (std::size_t k = 0; k < mesh.vertices.size(); ++k) {
    ASSERT_NEAR(ball(mesh.vertices[k].cast<double>()), 0, 1e-7);
    ASSERT_GT(mesh.normals[k].dot(mesh.vertices[k].normalized()), 0.99999f);
  }
  EXPECT_NEAR(mesh_checks::volume(mesh) / (4.0 / 3 * kPi * 1e-3), 1, 0.01);
}

TEST(ImplicitSurface, SmoothUnionIsTheUnionAwayFromTheFillet) {
  EXPECT_DOUBLE_EQ(smoothUnion(0.1, 0.2, 0.05), 0.1);
  EXPECT_DOUBLE_EQ(smoothUnion(0.2, 0.1, 0.05), 0.1);
  EXPECT_DOUBLE_EQ(smoothUnion(0.1, 0.1, 0.04), 0.09);
}

TEST(ImplicitSurface, CapsuleAndEllipsoidAreZeroOnTheirSurfaces) {
  EXPECT_NEAR(capsuleDistance({0.05, 0.03, 0}, {0, 0, 0}, {0.1, 0, 0}, 0.02, 0.04), 0, 1e-12);
  EXPECT_NEAR(capsuleDistance({-0.02, 0, 0}, {0, 0, 0}, {0.1, 0, 0}, 0.02, 0.04), 0, 1e-12);
  EXPECT_NEAR(ellipsoidDistance({1.2, 2, 3}, {1, 2, 3}, {0.2, 0.1, 0.3}), 0, 1e-12);
  EXPECT_LT(ellipsoidDistance({1, 2, 3}, {1, 2, 3}, {0.2, 0.1, 0.3}), 0);
}

TEST(Material, PatternsGoBetweenTheirTwoColours) {
  for (const auto pattern : {Material::Plain, Material::Checker, Material::Stripes, Material::Wood, Material::Noise}) {
    Material material{pattern, {200, 100, 50}, {100, 20, 10}, 0.05f, 0.7f};
    float least = 1e9f, most = -1e9f;
    for (int k = 0; k < 2000; ++k) {
      const auto at = static_cast<float>(k);
      const Vector3f c = albedo(material, {0.0137f * at, 0.0091f * at - 3, 0.0053f * at});
      ASSERT_TRUE((c.array() >= Eigen::Array3f(100, 20, 10) - 0.01f).all() &&
                  (c.array() <= Eigen::Array3f(200, 100, 50) + 0.01f).all());
      least = std::min(least, c.x());
      most = std::max(most, c.x());
    }
    EXPECT_GE(most, 185) << pattern;
    EXPECT_LE(least, pattern == Material::Plain ? 200 : 130) << pattern;
  }
}

TEST(Material, CheckerChangesColourFromOneSquareToTheNext) {
  const Material material{Material::Checker, {200, 200, 200}, {0, 0, 0}, 0.1f, 0.7f};
  for (int k = 0; k < 10; ++k) {
    const float x = 0.1f * static_cast<float>(k);
    EXPECT_NE(albedo(material, {x, 0, 0}).x(), albedo(material, {x + 0.1f, 0, 0}).x());
    EXPECT_EQ(albedo(material, {x, 0, 0}), albedo(material, {x + 0.1f, 0.1f, 0}));
  }
}

}  // namespace
