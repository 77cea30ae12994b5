#include "evaluation/tables/random_thinning.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <set>
#include <tuple>

namespace {

using fuse_flow::PointFused;
using Cloud = pcl::PointCloud<PointFused>;

/** \brief 100 × 100 × 1 points a centimetre apart, row by row. */
Cloud grid() {
  Cloud cloud;
  for (int y = 0; y < 100; ++y)
    for (int x = 0; x < 100; ++x) {
      PointFused& p = cloud.emplace_back();
      p.x = 0.01f * static_cast<float>(x);
      p.y = 0.01f * static_cast<float>(y);
      p.z = 1;
    }
  return cloud;
}

std::set<std::tuple<float, float>> places(const Cloud& cloud) {
  std::set<std::tuple<float, float>> result;
  for (const PointFused& p : cloud) result.emplace(p.x, p.y);
  return result;
}

Cloud thinned(Cloud cloud, std::size_t number, std::uint64_t seed = 1) {
  fuse_flow::tables::thinAtRandom(cloud, number, seed);
  return cloud;
}

TEST(RandomThinning, LeavesTheNumberAskedForAndAllWhereThereAreFewer) {
  EXPECT_EQ(places(thinned(grid(), 3000)).size(), 3000u);
  EXPECT_EQ(places(thinned(grid(), 20000)), places(grid()));
  EXPECT_TRUE(thinned(grid(), 0).empty());
}

TEST(RandomThinning, LeavesTheSamePointsWhateverTheirOrder) {
  Cloud reversed = grid();
  std::reverse(reversed.begin(), reversed.end());
  EXPECT_EQ(places(thinned(grid(), 3000)), places(thinned(reversed, 3000)));
}

TEST(RandomThinning, AnotherSeedLeavesOtherPoints) {
  const auto first = places(thinned(grid(), 3000, 1)), second = places(thinned(grid(), 3000, 2));
  std::size_t both = 0;
  for (const auto& place : first) both += second.count(place);
  EXPECT_NEAR(static_cast<double>(both), 900, 120);  // 3 of 10 of 3000; σ is 21
}

TEST(RandomThinning, LeavesTheSameShareEverywhere) {
  // A quarter of the cloud holds a quarter of what stays: 750, σ 24.
  std::array<int, 4> kept{};
  for (const PointFused& p : thinned(grid(), 3000)) ++kept[(p.x < 0.495f ? 0u : 1u) + (p.y < 0.495f ? 0u : 2u)];
  for (const int n : kept) EXPECT_NEAR(n, 750, 120);
}

}  // namespace
