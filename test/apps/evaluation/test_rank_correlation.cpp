#include "evaluation/tables/rank_correlation.h"

#include <gtest/gtest.h>

namespace {

using fuse_flow::tables::rankCorrelation;
using fuse_flow::tables::ranksOf;

TEST(RankCorrelation, OrderAloneCounts) {
  EXPECT_NEAR(rankCorrelation({1, 2, 3, 4}, {1, 10, 100, 1000}), 1, 1e-12);
  EXPECT_NEAR(rankCorrelation({1, 2, 3, 4}, {4, 3, 2, -9}), -1, 1e-12);
  EXPECT_NEAR(rankCorrelation({1, 2, 3, 4, 5}, {2, 1, 4, 3, 5}), 0.8, 1e-12);  // 1 − 6 · 4 / (5 · 24)
}

TEST(RankCorrelation, EqualValuesShareTheirRanks) {
  EXPECT_EQ(ranksOf({7, 3, 7, 9}), (std::vector<double>{2.5, 1, 2.5, 4}));
}

TEST(RankCorrelation, WhatIsNotKnownDoesNotCount) {
  const double nan = std::nan("");
  EXPECT_NEAR(rankCorrelation({1, nan, 2, 3}, {5, 1, 6, 7}), 1, 1e-12);
  EXPECT_TRUE(std::isnan(rankCorrelation({1, nan, 2}, {5, 1, 6})));
  EXPECT_TRUE(std::isnan(rankCorrelation({1, 1, 1}, {5, 1, 6})));
}

}  // namespace
