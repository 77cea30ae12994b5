#include <fuse_flow/math/representatives.h>

#include <gtest/gtest.h>

#include <set>
#include <vector>

using namespace fuse_flow;

namespace {

FusedPoint fusedPointWise(const std::vector<float>& weights) {
  PointWiseFusion fusion({0, 0, 1});
  for (std::uint32_t k = 0; k < weights.size(); ++k) fusion.add(k, {0.001f * static_cast<float>(k), 0, 1}, weights[k]);
  return fusion.finish();
}

std::set<std::uint32_t> sources(const FusedPoint& p) { return {p.source, p.source + p.count}; }

TEST(PointWiseFusion, AllMakeThePointAndTheThreeOfMostWeightStandForIt) {
  const FusedPoint p = fusedPointWise({0.2f, 0.4f, 0.1f, 0.8f, 0.1f, 0.4f});
  EXPECT_NEAR(p.p.x, 0.001f * (0.4f + 0.2f + 3 * 0.8f + 0.4f + 5 * 0.4f) / 2.0f, 1e-8f);
  EXPECT_NEAR(p.weight, (0.04f + 0.16f + 0.01f + 0.64f + 0.01f + 0.16f) / 2.0f, 1e-6f);
  EXPECT_EQ(p.views, 6u);
  ASSERT_EQ(p.count, 3u);
  EXPECT_EQ(sources(p), (std::set<std::uint32_t>{1, 3, 5}));
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(p.share[k], p.source[k] == 3 ? 0.5f : 0.25f, 1e-6f);
}

TEST(PointWiseFusion, PointsOfNoWeightTakeNobodysPlace) {
  const FusedPoint p = fusedPointWise({0, 0, 0, 0.5f});
  EXPECT_NEAR(p.p.x, 0.003f, 1e-8f);
  EXPECT_FLOAT_EQ(p.weight, 0.5f);
  float total = 0;
  for (std::size_t k = 0; k < p.count; ++k) {
    EXPECT_EQ(p.share[k], p.source[k] == 3 ? 1.0f : 0.0f);
    total += p.share[k];
  }
  EXPECT_EQ(total, 1.0f);
}

TEST(PointWiseFusion, OfEqualOnesTheFirstStay) {
  EXPECT_EQ(sources(fusedPointWise({0.5f, 0.5f, 0.5f, 0.5f})), (std::set<std::uint32_t>{0, 1, 2}));
  EXPECT_EQ(fusedPointWise({0, 0, 0, 0}).weight, 0.0f);
}

}  // namespace
