#include <fuse_flow/math/exponential.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace {

using fuse_flow::expOfNegative;

TEST(Exponential, IsOneAtZeroAndNothingFarBelow) {
  EXPECT_EQ(expOfNegative(0.0f), 1.0f);
  EXPECT_EQ(expOfNegative(-0.0f), 1.0f);
  EXPECT_EQ(expOfNegative(-std::numeric_limits<float>::denorm_min()), 1.0f);
  EXPECT_GT(expOfNegative(-87.0f), 0.0f);
  EXPECT_EQ(expOfNegative(std::nextafter(-87.0f, -88.0f)), 0.0f);
  EXPECT_EQ(expOfNegative(-std::numeric_limits<float>::infinity()), 0.0f);
  EXPECT_EQ(expOfNegative(std::numeric_limits<float>::quiet_NaN()), 0.0f);
}

TEST(Exponential, IsWithinOneUnitInTheLastPlace) {
  for (float x = 0; x >= -87.0f; x = std::nextafter(x * 1.00007f, -88.0f) - 1e-6f) {
    const double exact = std::exp(static_cast<double>(x));
    int exponent = 0;
    std::frexp(exact, &exponent);
    ASSERT_NEAR(static_cast<double>(expOfNegative(x)), exact, std::ldexp(1.0, exponent - 24)) << x;
  }
}

/** \brief Where the nearest multiple of ln 2 changes, two polynomials meet. */
TEST(Exponential, NeverFallsWhereItsArgumentRises) {
  for (int k = 0; k < 125; ++k) {
    float x = static_cast<float>(-(k + 0.5) * 0.69314718056) * 1.00001f;
    for (int step = 0; step < 1000; ++step) {
      const float next = std::nextafter(x, 0.0f);
      ASSERT_LE(expOfNegative(x), expOfNegative(next)) << x;
      x = next;
    }
  }
  for (float x = -87.0f; x < -1e-6f; x *= 0.9999f) ASSERT_LE(expOfNegative(x), expOfNegative(x * 0.9999f)) << x;
}

}  // namespace
