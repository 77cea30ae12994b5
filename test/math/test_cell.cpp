#include <fuse_flow/math/box.h>
#include <fuse_flow/math/cell.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <vector>

namespace {

using namespace fuse_flow;

const std::vector<std::int32_t> kCoordinates{-kMaxCellCoordinate, -1000, -2, -1, 0, 1, 2, 1000, kMaxCellCoordinate};

TEST(Cell, KeysTurnBackIntoTheirCellsNegativeOnesToo) {
  for (const std::int32_t x : kCoordinates)
    for (const std::int32_t y : kCoordinates)
      for (const std::int32_t z : kCoordinates) {
        const CellIndex back = cellOfKey(cellKey({x, y, z}));
        ASSERT_EQ(back.x, x);
        ASSERT_EQ(back.y, y);
        ASSERT_EQ(back.z, z);
      }
}

TEST(Cell, DistinctCellsHaveDistinctKeys) {
  std::set<std::uint64_t> keys;
  std::size_t cells = 0;
  for (const std::int32_t x : kCoordinates)
    for (const std::int32_t y : kCoordinates)
      for (const std::int32_t z : kCoordinates) {
        keys.insert(cellKey({x, y, z}));
        ++cells;
      }
  for (std::int32_t x = -10; x < 10; ++x)
    for (std::int32_t y = -10; y < 10; ++y)
      for (std::int32_t z = 10; z < 30; ++z) {
        keys.insert(cellKey({x, y, z}));
        ++cells;
      }
  EXPECT_EQ(keys.size(), cells);
}

TEST(Cell, HashingKeysIsInjectiveOnABlockOfNeighbours) {
  std::set<std::uint64_t> hashes;
  for (std::int32_t x = -8; x < 8; ++x)
    for (std::int32_t y = -8; y < 8; ++y)
      for (std::int32_t z = -8; z < 8; ++z) hashes.insert(hashCellKey(cellKey({x, y, z})));
  EXPECT_EQ(hashes.size(), 16u * 16u * 16u);
}

TEST(Cell, FloorRoundsDownOnBothSidesOfZero) {
  EXPECT_EQ(floorToInt(0.0f), 0);
  EXPECT_EQ(floorToInt(-0.0f), 0);
  EXPECT_EQ(floorToInt(0.999f), 0);
  EXPECT_EQ(floorToInt(1.0f), 1);
  EXPECT_EQ(floorToInt(-1e-6f), -1);
  EXPECT_EQ(floorToInt(-0.5f), -1);
  EXPECT_EQ(floorToInt(-1.0f), -1);
  EXPECT_EQ(floorToInt(-1.001f), -2);
  EXPECT_EQ(floorToInt(-1048573.5f), -1048574);
}

TEST(Cell, IndexFloorsEveryAxis) {
  const CellIndex c = cellIndex({-0.25f, 2.75f, -3.0f});
  EXPECT_EQ(c.x, -1);
  EXPECT_EQ(c.y, 2);
  EXPECT_EQ(c.z, -3);
}

TEST(Cell, WhatIsNotFiniteFitsNoKey) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  for (const float bad : {nan, inf, -inf}) {
    EXPECT_FALSE(fitsCellKey({bad, 0, 0}));
    EXPECT_FALSE(fitsCellKey({0, bad, 0}));
    EXPECT_FALSE(fitsCellKey({0, 0, bad}));
  }
}

TEST(Cell, OnlyWhatLiesWithinTwentyOneBitsAnAxisFitsAKey) {
  EXPECT_TRUE(fitsCellKey({0, 0, 0}));
  EXPECT_TRUE(fitsCellKey({1048573, -1048573, 1048573}));
  for (const float far : {1048576.0f, -1048576.0f, 1e7f, -1e30f}) {
    EXPECT_FALSE(fitsCellKey({far, 0, 0}));
    EXPECT_FALSE(fitsCellKey({0, far, 0}));
    EXPECT_FALSE(fitsCellKey({0, 0, far}));
  }
}

TEST(Cell, EverythingThatFitsSurvivesItsKey) {
  for (const float v : {1048573.0f, -1048573.0f, -1048573.5f, 1048573.5f}) {
    ASSERT_TRUE(fitsCellKey({v, v, v}));
    const CellIndex c = cellIndex({v, v, v});
    EXPECT_EQ(static_cast<float>(c.x), std::floor(v));
    EXPECT_EQ(cellOfKey(cellKey(c)).x, c.x);
    EXPECT_EQ(cellOfKey(cellKey(c)).z, c.z);
  }
}

TEST(RefinementLevel, SplitsUntilFourToTheLevelChildrenHoldTheWantedNumberEach) {
  // One point a cell: 1 → 0, up to 4 → 1, up to 16 → 2, up to 64 → 3.
  EXPECT_EQ(refinementLevel(0, 1, 5), 0);
  EXPECT_EQ(refinementLevel(1, 1, 5), 0);
  EXPECT_EQ(refinementLevel(2, 1, 5), 1);
  EXPECT_EQ(refinementLevel(4, 1, 5), 1);
  EXPECT_EQ(refinementLevel(5, 1, 5), 2);
  EXPECT_EQ(refinementLevel(16, 1, 5), 2);
  EXPECT_EQ(refinementLevel(17, 1, 5), 3);
  EXPECT_EQ(refinementLevel(64, 1, 5), 3);
  EXPECT_EQ(refinementLevel(65, 1, 5), 4);
}

TEST(RefinementLevel, CountsInUnitsOfThePointsWantedInACell) {
  EXPECT_EQ(refinementLevel(4, 4, 5), 0);
  EXPECT_EQ(refinementLevel(5, 4, 5), 1);
  EXPECT_EQ(refinementLevel(16, 4, 5), 1);
  EXPECT_EQ(refinementLevel(17, 4, 5), 2);
  EXPECT_EQ(refinementLevel(1, 0.5f, 5), 1);
}

TEST(RefinementLevel, StopsAtTheSmallestCell) {
  EXPECT_EQ(refinementLevel(1000000, 1, 3), 3);
  EXPECT_EQ(refinementLevel(1000000, 1, 0), 0);
  EXPECT_EQ(refinementLevel(4294967295u, 1, 5), 5);
}

TEST(Cell, KeysHoldCellsUpToTheFarthestButOne) {
  const float last = static_cast<float>(kMaxCellCoordinate - 1);
  EXPECT_TRUE(fitsCellKey({std::nextafter(last, 0.0f), 0, 0}));
  for (const float out : {last, -last, static_cast<float>(kMaxCellCoordinate), INFINITY, NAN}) {
    EXPECT_FALSE(fitsCellKey({out, 0, 0})) << out;
    EXPECT_FALSE(fitsCellKey({0, out, 0})) << out;
    EXPECT_FALSE(fitsCellKey({0, 0, out})) << out;
  }
}

TEST(Box, ItsBordersAreInside) {
  const Box box{{-1, -2, -3}, {1, 2, 3}};
  EXPECT_TRUE(box.contains({-1, -2, -3}));
  EXPECT_TRUE(box.contains({1, 2, 3}));
  const auto beyond = [](float v) { return std::nextafter(v, 2 * v); };
  EXPECT_FALSE(box.contains({beyond(-1), 0, 0}));
  EXPECT_FALSE(box.contains({beyond(1), 0, 0}));
  EXPECT_FALSE(box.contains({0, beyond(-2), 0}));
  EXPECT_FALSE(box.contains({0, beyond(2), 0}));
  EXPECT_FALSE(box.contains({0, 0, beyond(-3)}));
  EXPECT_FALSE(box.contains({0, 0, beyond(3)}));
  EXPECT_TRUE(Box().contains({1e38f, -1e38f, 0})) << "all of the world";
}

}  // namespace
