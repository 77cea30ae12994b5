#include <fuse_flow/math/depth.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace {

using namespace fuse_flow;

TEST(Metres, TheRangeIncludesBothItsEnds) {
  // A 1024th of a metre a unit, so that nothing is rounded.
  const float unit = 1.0f / 1024;
  EXPECT_EQ(metres(std::uint16_t{512}, unit, 0.5f, 4), 0.5f);
  EXPECT_EQ(metres(std::uint16_t{511}, unit, 0.5f, 4), 0.0f);
  EXPECT_EQ(metres(std::uint16_t{4096}, unit, 0.5f, 4), 4.0f);
  EXPECT_EQ(metres(std::uint16_t{4097}, unit, 0.5f, 4), 0.0f);
  EXPECT_EQ(metres(0.5f, 0.5f, 4), 0.5f);
  EXPECT_EQ(metres(std::nextafter(0.5f, 0.0f), 0.5f, 4), 0.0f);
  EXPECT_EQ(metres(4.0f, 0.5f, 4), 4.0f);
  EXPECT_EQ(metres(std::nextafter(4.0f, 5.0f), 0.5f, 4), 0.0f);
}

TEST(Metres, WhatIsNoMeasurementIsNoneInAnyRange) {
  EXPECT_EQ(metres(std::uint16_t{0}, 1, 0, 1e6f), 0.0f);
  EXPECT_EQ(metres(std::uint16_t{65535}, 1, 0, 1e6f), 0.0f);
  EXPECT_EQ(metres(std::uint16_t{65534}, 1, 0, 1e6f), 65534.0f);
  for (const float none : {0.0f, -1.0f, NAN, INFINITY, -INFINITY}) EXPECT_EQ(metres(none, 0, 1e6f), 0.0f) << none;
}

TEST(FilledDepth, IsTheMeanOfEnoughNeighboursOfOneSurface) {
  PreprocessingParameters p;
  p.fill_neighbours = 4;
  p.fill_tolerance = 0.125f;
  EXPECT_EQ(filledDepth(p, {0.5f, 0, 0.625f, 0, 0, 0, 0.5f, 0, 0.625f}), 0.5625f);
  EXPECT_EQ(filledDepth(p, {0.5f, 0, 0.625f, 0, 0, 0, 0.5f, 0, 0}), 0.0f) << "three";
  EXPECT_EQ(filledDepth(p, {0.5f, -1, 0.625f, 0, 0, 0, 0.5f, 0, NAN}), 0.0f) << "three, and what is no depth";
}

TEST(FilledDepth, NeighboursMayDifferByTheToleranceWhichGrowsWithDepthBeyondAMetre) {
  PreprocessingParameters p;
  p.fill_neighbours = 2;
  p.fill_tolerance = 0.125f;
  // The nearest one first, last, or between, so that the order does not matter.
  EXPECT_EQ(filledDepth(p, {0.5f, 0.625f}), 0.5625f);
  EXPECT_EQ(filledDepth(p, {0.625f, 0.5f}), 0.5625f);
  EXPECT_EQ(filledDepth(p, {0.5f, std::nextafter(0.625f, 1.0f)}), 0.0f);
  EXPECT_EQ(filledDepth(p, {std::nextafter(0.625f, 1.0f), 0.5f}), 0.0f);
  // At two metres four times as much.
  EXPECT_EQ(filledDepth(p, {1.75f, 2.25f}), 2.0f);
  EXPECT_EQ(filledDepth(p, {1.75f, 2.2501f, 0, 0, 0, 0, 0, 0, 1.9f}), 0.0f);
}

}  // namespace
