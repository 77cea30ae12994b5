#include "simulation/random.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

namespace {

using fuse_flow::simulation::Random;

TEST(Random, DrawsTheNumbersOfSplitMix64) {
  // Computed with another implementation of the published generator, to 53 bits.
  Random random(1, 2, 3, 4);
  for (const std::uint64_t draw : {0x1605eae120e93bull, 0xaaeb25cc99904ull, 0x1286b2ff95066ull, 0x4c9f281e31a73ull})
    EXPECT_EQ(random.uniform() * 0x1p53, static_cast<double>(draw));
}

TEST(Random, GaussianNumbersHaveMeanZeroAndVarianceOne) {
  Random random(1, 0, 0, 0);
  constexpr int n = 100000;
  double sum = 0, squares = 0;
  for (int i = 0; i < n; ++i) {
    const double x = random.gaussian();
    ASSERT_LE(std::abs(x), 6);
    sum += x;
    squares += x * x;
  }
  EXPECT_NEAR(sum / n, 0, 0.02);
  EXPECT_NEAR(squares / n, 1, 0.02);
}

}  // namespace
