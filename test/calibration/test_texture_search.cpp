#include "../rigs.h"

#include <fuse_flow/impl/calibration/alignment_system.hpp>
#include <fuse_flow/impl/calibration/coarse/level_directions.hpp>
#include <fuse_flow/impl/calibration/coarse/texture_search.hpp>

#include <limits>
#include <random>

namespace {

using Eigen::Vector3d;
using fuse_flow::host::BrightnessCorrelation;
using fuse_flow::host::PlaneTexture;
using fuse_flow::host::PlaneTextures;
using fuse_flow::host::TextureMatch;
using fuse_flow::host::TextureSearch;

/** \brief n points, half of them this much brighter than a mean, half of them darker; and others of a second view. */
BrightnessCorrelation alternating(int n, double first, double second, double brighter = 0) {
  BrightnessCorrelation sums;
  for (int k = 0; k < n; ++k) {
    const double sign = k % 2 == 0 ? 1 : -1;
    sums.add(100 + sign * first, 100 + brighter + sign * second);
  }
  return sums;
}

// Variances of 1 and the noise's 1, covariance 1: r = 1 / 2, and artanh(1 / 2) = 0.549306.
TEST(BrightnessCorrelation, EvidenceIsFishersZOverItsDeviation) {
  EXPECT_NEAR(alternating(100, 1, 1).evidence(), 10 * 0.549306, 1e-5);
  EXPECT_NEAR(alternating(400, 1, 1).evidence(), 20 * 0.549306, 1e-5);
  // Variances of 9 + 1 and 4 + 1, covariance 6: r = 6 / √50, artanh(0.848528) = 1.250872.
  EXPECT_NEAR(alternating(100, 3, 2).evidence(), 10 * 1.250872, 1e-4);
}

TEST(BrightnessCorrelation, HowBrightOneIsAsAWholeDoesNotCount) {
  EXPECT_NEAR(alternating(100, 1, 1, 55).evidence(), alternating(100, 1, 1).evidence(), 1e-6);
}

TEST(BrightnessCorrelation, WhatSaysNothingIsNoEvidence) {
  EXPECT_EQ(alternating(100, 0, 0).evidence(), 0);   // no paint
  EXPECT_EQ(alternating(100, 5, 0).evidence(), 0);   // in one view only
  EXPECT_EQ(alternating(100, 5, -5).evidence(), 0);  // the contrary
  EXPECT_EQ(alternating(28, 5, 5).evidence(), 0);    // too few
  EXPECT_GT(alternating(30, 5, 5).evidence(), 0);
}

// Sums of floats would come to a correlation of 0.3 and more, or to the root of a negative number.
TEST(BrightnessCorrelation, LongSumsOfOneLevelAreNoEvidence) {
  BrightnessCorrelation sums;
  for (int k = 0; k < 100000; ++k) sums.add(static_cast<double>(87.77f), static_cast<double>(93.21f));
  EXPECT_NEAR(sums.evidence(), 0, 1e-3);
}

TEST(BrightnessCorrelation, WhatAgreesWhollyIsNotInfinitelyCertain) {
  EXPECT_NEAR(alternating(100, 100, 100).evidence(), 10 * 2.646652, 1e-3);  // artanh(0.99)
}

/** \brief Tiles of 0.25 m, none like its neighbours. */
double tiles(double x, double z, unsigned int seed) {
  const auto i = static_cast<int>(std::floor(4 * x)), j = static_cast<int>(std::floor(4 * z));
  std::mt19937 random(seed + static_cast<unsigned int>(1000 + 97 * i + 7919 * j));
  return 40 + static_cast<double>(random() % 160);
}
double paint(double x, double z) { return tiles(x, z, 1); }
double otherPaint(double x, double z) { return tiles(x, z, 100000); }

/** \brief A camera that looks down on the floor y = 1.3. */
fuse_flow::Camera overFloor(double x, double z, double degrees) {
  const double a = degrees * scenes::kDegree;
  return scenes::lookAt({x, 0, z}, {x + std::cos(a), 1.3, z + std::sin(a)}, 160, 120, 130);
}

/** \brief What such a camera knows of the floor, as far as one metre around the point it looks at. */
PlaneTexture floorOf(const fuse_flow::Camera& camera, double (*grey)(double, double), float brighter = 0) {
  const Eigen::Isometry3d T = camera.T_world_camera.inverse();
  PlaneTexture plane;
  const Vector3d normal = T.linear() * -Vector3d::UnitY();
  plane.axes << normal.unitOrthogonal(), normal.cross(normal.unitOrthogonal()), normal;
  plane.height = normal.dot(T * Vector3d(0, 1.3, 0));
  const Vector3d axis = camera.T_world_camera.linear().col(2);
  const Vector3d target = camera.T_world_camera.translation() + axis * (1.3 / axis.y());
  for (double z = target.z() - 1; z < target.z() + 1; z += 0.04)
    for (double x = target.x() - 1; x < target.x() + 1; x += 0.04) {
      const Vector3d p = plane.axes.transpose() * (T * Vector3d(x, 1.3, z));
      plane.points.push_back(
          {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(grey(x, z)) + brighter});
    }
  return plane;
}

std::vector<TextureMatch> search(const PlaneTexture& first, const PlaneTexture& second) {
  std::vector<TextureMatch> found;
  TextureSearch(0.1f, 1000).search(first, second, found);
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.evidence > b.evidence; });
  return found;
}

void expectBest(const std::vector<TextureMatch>& found, const fuse_flow::Camera& first,
                const fuse_flow::Camera& second) {
  ASSERT_FALSE(found.empty());
  const Eigen::Isometry3d expected = first.T_world_camera.inverse() * second.T_world_camera;
  EXPECT_LT(scenes::apart(found[0].T, expected), 0.1);   // a cell
  EXPECT_LT(scenes::turned(found[0].T, expected), 5.1);  // from turn to turn
}

TEST(TextureSearch, FindsWhereTheFloorOfOneViewLiesOnThatOfAnother) {
  const auto a = overFloor(0, 0, 20), b = overFloor(0.5, -0.4, 70), c = overFloor(1.6, 0.9, 203);
  const PlaneTexture floor_a = floorOf(a, paint);
  expectBest(search(floor_a, floorOf(b, paint)), a, b);
  expectBest(search(floor_a, floorOf(c, paint)), a, c);
  expectBest(search(floorOf(b, paint), floor_a), b, a);
}

TEST(TextureSearch, AnExposureMakesNoDifference) {
  const auto a = overFloor(0, 0, 20), b = overFloor(0.5, -0.4, 70);
  const auto same = search(floorOf(a, paint), floorOf(b, paint));
  const auto brighter = search(floorOf(a, paint), floorOf(b, paint, 60));
  expectBest(brighter, a, b);
  EXPECT_NEAR(brighter[0].evidence, same[0].evidence, 0.01 * same[0].evidence);
}

TEST(TextureSearch, OtherPaintIsMuchLessEvidence) {
  const auto a = overFloor(0, 0, 20), b = overFloor(0.2, -0.1, 43);
  const auto same = search(floorOf(a, paint), floorOf(b, paint));
  const auto other = search(floorOf(a, paint), floorOf(b, otherPaint));
  ASSERT_FALSE(same.empty());
  EXPECT_LT(other.empty() ? 0 : other[0].evidence, 0.6 * same[0].evidence);
}

TEST(TextureSearch, APlaneWithoutPaintTellsNothing) {
  const auto a = overFloor(0, 0, 20), b = overFloor(0.5, -0.4, 70);
  const auto plain = [](double, double) { return 120.0; };
  EXPECT_TRUE(search(floorOf(a, plain), floorOf(b, plain)).empty());
  EXPECT_TRUE(search(floorOf(a, plain), floorOf(b, paint)).empty());
}

/** \brief A square of n × n cells along the plane's axes, two blocks in each, grey as its tiles. */
PlaneTexture square(int n) {
  PlaneTexture plane;
  plane.axes.setIdentity();
  plane.height = -1;
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x)
      for (const float offset : {0.03f, 0.07f})
        plane.points.push_back({0.1f * static_cast<float>(x) + offset, 0.1f * static_cast<float>(y) + offset,
                                static_cast<float>(paint(2.5 * x, 2.5 * y))});
  return plane;
}

TEST(TextureSearch, PlanesThatShareFewerCellsThanThirtyMatchNowhere) {
  EXPECT_TRUE(search(square(5), square(5)).empty());
  const auto found = search(square(6), square(6));
  ASSERT_FALSE(found.empty());
  EXPECT_LT(scenes::apart(found[0].T, Eigen::Isometry3d::Identity()), 1e-5);
  EXPECT_LT(scenes::turned(found[0].T, Eigen::Isometry3d::Identity()), 1e-5);
}

TEST(TextureSearch, KeepsTheBestOfAllThatItFinds) {
  const PlaneTexture a = floorOf(overFloor(0, 0, 20), paint), b = floorOf(overFloor(0.5, -0.4, 70), paint);
  const auto all = search(a, b);
  ASSERT_GT(all.size(), 5u);
  std::vector<TextureMatch> few;
  TextureSearch(0.1f, 5).search(a, b, few);
  ASSERT_EQ(few.size(), 5u);
  for (const TextureMatch& match : few) EXPECT_GE(match.evidence, all[4].evidence);
}

TEST(TextureMap, HoldsTheCellsOfSeveralBlocksAndWhatLiesBetweenThem) {
  PlaneTexture plane = square(3);
  plane.points.push_back({2.55f, 0.05f, 77.0f});  // a block alone
  fuse_flow::host::TextureMap map;
  map.assign(plane, 0, 0.1f);
  ASSERT_EQ(map.width(), 3);
  ASSERT_EQ(map.height(), 3);
  EXPECT_NEAR(map.low().norm(), 0, 1e-6);
  double mean = 0;
  for (int k = 0; k < 9; ++k) mean += std::round(paint(2.5 * (k % 3), 2.5 * (k / 3))) / 9;
  for (int k = 0; k < 9; ++k) {
    EXPECT_EQ(map.known()[map.index(k % 3, k / 3)], 1);
    EXPECT_NEAR(map.levels()[map.index(k % 3, k / 3)], paint(2.5 * (k % 3), 2.5 * (k / 3)) - mean, 1e-3);
  }
  map.assign(plane, 1.5707963, 0.1f);  // a quarter turn: (x, y) → (−y, x)
  ASSERT_EQ(map.width(), 3);
  EXPECT_NEAR(map.low().x(), -0.3, 1e-6);
  EXPECT_NEAR(map.low().y(), 0, 1e-6);
  EXPECT_NEAR(map.levels()[map.index(2, 1)], paint(2.5, 0) - mean, 1e-3);
}

TEST(TextureMap, WhatLiesFarAwayTakesNoMemory) {
  PlaneTexture plane = square(3);
  const auto infinite = std::numeric_limits<float>::infinity();
  for (const float far : {12.0f, 1e4f, 1e7f, 1e30f, infinite, std::numeric_limits<float>::quiet_NaN()})
    for (int k = 0; k < 4; ++k) plane.points.push_back({far, -far, 10.0f});
  fuse_flow::host::TextureMap map;
  map.assign(plane, 0, 0.1f);
  EXPECT_EQ(map.width(), 3);
  plane.points.erase(plane.points.begin(), plane.points.begin() + 18);
  map.assign(plane, 0, 0.1f);
  EXPECT_TRUE(map.empty());
  EXPECT_TRUE(search(plane, square(6)).empty());
  EXPECT_TRUE(search(square(6), plane).empty());
}

/** \brief A view of a floor at y = 1.3 and, over a part of it, a table at y = 0.6, seen from above. */
fuse_flow::host::AlignmentSystem tableFromAbove(bool colored) {
  const auto camera = scenes::lookAt({0, 0, 0}, {0.02, 1.3, 0.01}, 160, 120, 130);
  scenes::Scene scene = scenes::makeScene({camera}, [](const Vector3d& origin, const Vector3d& direction) {
    const double table = scenes::plane({0, 1, 0}, 0.6)(origin, direction);
    return (origin + table * direction).x() > 0.1 ? table : scenes::plane({0, 1, 0}, 1.3)(origin, direction);
  });
  if (colored) scenes::paintWorld(scene, [](const Vector3d& x) { return x.y() < 1 ? 200 : 50; });
  fuse_flow::ExtrinsicParameters p;
  p.reduction = 1;
  fuse_flow::host::AlignmentSystem system(1);
  system.add(scene.rig, p);
  return system;
}

TEST(PlaneTextures, PlanesOfOneDirectionAreToldApartByTheirHeight) {
  const fuse_flow::host::AlignmentSystem system = tableFromAbove(true);
  const Vector3d up = -scenes::lookAt({0, 0, 0}, {0.02, 1.3, 0.01}).T_world_camera.linear().transpose().col(1);
  const Eigen::Isometry3d T = scenes::lookAt({0, 0, 0}, {0.02, 1.3, 0.01}).T_world_camera;
  const PlaneTextures textures(system.view(0, 0), up);
  ASSERT_EQ(textures.planes().size(), 2u);
  for (const PlaneTexture& plane : textures.planes()) {
    const bool table = plane.height > -0.95;
    EXPECT_NEAR(plane.height, table ? -0.6 : -1.3, 0.002);
    EXPECT_NEAR((plane.axes.transpose() * plane.axes - Eigen::Matrix3d::Identity()).norm(), 0, 1e-9);
    EXPECT_NEAR(plane.axes.determinant(), 1, 1e-9);
    EXPECT_LT((plane.axes.col(2) - up).norm(), 1e-9);
    for (const PlaneTexture::Point& p : plane.points) {
      ASSERT_NEAR(p.luma, table ? 200 : 50, 1);
      const Vector3d x = T * (plane.axes * Vector3d(p.x, p.y, plane.height));
      ASSERT_NEAR(x.y(), table ? 0.6 : 1.3, 0.005);
      ASSERT_GT(x.x(), table ? 0.08 : -10);
    }
  }
  EXPECT_NE(textures.planes()[0].height > -0.95, textures.planes()[1].height > -0.95);
}

TEST(PlaneTextures, WithoutColourOrInAnotherDirectionThereIsNone) {
  const Vector3d up = -scenes::lookAt({0, 0, 0}, {0.02, 1.3, 0.01}).T_world_camera.linear().transpose().col(1);
  EXPECT_TRUE(PlaneTextures(tableFromAbove(false).view(0, 0), up).planes().empty());
  EXPECT_TRUE(PlaneTextures(tableFromAbove(true).view(0, 0), up.unitOrthogonal()).planes().empty());
}

TEST(LevelDirections, AreThoseOfFloorsWhereBothViewsMayHaveOne) {
  const double tilt = 0.6;  // radians that the camera looks down
  const Vector3d floor(0, -std::cos(tilt), -std::sin(tilt)), wall(0, std::sin(tilt), -std::cos(tilt)), side(1, 0, 0);
  const fuse_flow::host::LevelDirections level({side, floor, wall}, {floor, side}, 0.35);
  EXPECT_TRUE(level.floors());
  EXPECT_EQ(level.first(), std::vector<Vector3d>{floor});
  EXPECT_EQ(level.second(), std::vector<Vector3d>{floor});
  const fuse_flow::host::LevelDirections without({side, wall, floor}, {side, wall}, 0.35);
  EXPECT_FALSE(without.floors());
  EXPECT_EQ(without.first(), (std::vector<Vector3d>{side, wall}));               // the strongest
  EXPECT_FALSE(fuse_flow::host::LevelDirections({floor}, {floor}, 4).floors());  // nothing is known about floors
  const Vector3d rolled = Eigen::AngleAxisd(0.5, Vector3d::UnitZ()) * floor;
  EXPECT_FALSE(fuse_flow::host::LevelDirections({rolled}, {floor}, 0.35).floors());  // too far for an upright camera
  EXPECT_TRUE(fuse_flow::host::LevelDirections({rolled}, {floor}, 0.7).floors());
}

}  // namespace
