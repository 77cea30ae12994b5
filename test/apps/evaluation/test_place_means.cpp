#include "evaluation/tables/place_means.h"

#include <gtest/gtest.h>

#include <limits>

namespace {

using fuse_flow::tables::PlaceMeans;

TEST(PlaceMeans, EachPlaceCountsAlike) {
  // Ten points at 1 and one at 4 in one cube each; the other cloud has 2 in both.
  std::vector<Eigen::Vector3f> positions(10, {0.001f, 0.001f, 0.001f});
  std::vector<float> distances(10, 1.0f);
  positions.emplace_back(0.011f, 0.001f, 0.001f);
  distances.push_back(4);
  const PlaceMeans crowded(positions, distances, 0.01f);
  const PlaceMeans even({{0.009f, 0.009f, 0.009f}, {0.019f, 0.0f, 0.0f}}, {2, 2}, 0.01f);
  EXPECT_DOUBLE_EQ(crowded.ratioTo(even), 1.25);
  EXPECT_DOUBLE_EQ(even.ratioTo(crowded), 0.8);
  EXPECT_DOUBLE_EQ(even.ratioTo(even), 1);
}

TEST(PlaceMeans, PlacesOfOneAloneDoNotCount) {
  const PlaceMeans wide({{-0.001f, 0, 0}, {0.001f, 0, 0}, {1, 0, 0}}, {100, 3, 100}, 0.01f);
  const PlaceMeans here({{0.002f, 0, 0}, {0.5f, 0, 0}}, {6, 50}, 0.01f);
  EXPECT_DOUBLE_EQ(wide.ratioTo(here), 0.5);
  EXPECT_DOUBLE_EQ(here.ratioTo(wide), 2);
}

TEST(PlaceMeans, PointsThatAreNowhereDoNotCount) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const PlaceMeans some({{0, 0, 0}, {nan, 0, 0}, {0, nan, 0}}, {1, 50, 60}, 0.01f), whole({{0, 0, 0}}, {2}, 0.01f);
  EXPECT_DOUBLE_EQ(some.ratioTo(whole), 0.5);
}

TEST(PlaceMeans, WithoutACommonPlaceThereIsNoRatio) {
  const PlaceMeans here({{0, 0, 0}}, {1}, 0.01f), there({{1, 0, 0}}, {1}, 0.01f);
  EXPECT_TRUE(std::isnan(here.ratioTo(there)));
}

}  // namespace
