#include <fuse_flow/math/block_average.h>

#include <gtest/gtest.h>

namespace {

/** \brief Five blocks of one surface, blurred at the middle one. */
float blurred(const float (&luma)[5], float depth_of_last = 2.0f) {
  fuse_flow::LumaBlur blur(2.0f);
  for (int k = -2; k <= 2; ++k) blur.add(k, k == 2 ? depth_of_last : 2.0f, luma[k + 2]);
  return blur.mean();
}

TEST(LumaBlur, WeighsNeighboursOfTheSameSurfaceAsABinomial) {
  EXPECT_FLOAT_EQ(blurred({16, 32, 48, 64, 80}), 48);
  EXPECT_FLOAT_EQ(blurred({16, 32, 48, 64, 80}, 2.2f), (16 + 4 * 32 + 6 * 48 + 4 * 64) / 15.0f);
}

// As beyond the border of a colour image that shows less than the depth image.
TEST(LumaBlur, BlocksWithoutAGreyLevelDarkenNothing) {
  EXPECT_FLOAT_EQ(blurred({100, 100, 100, -1, -1}), 100);
  EXPECT_FLOAT_EQ(blurred({16, 32, 48, -1, -1}), (16 + 4 * 32 + 6 * 48) / 11.0f);
  EXPECT_FLOAT_EQ(blurred({0, 0, 0, 0, 0}), 0);
}

TEST(LumaBlur, ABlockWithoutDepthOrGreyLevelHasNone) {
  EXPECT_LT(blurred({100, 100, -1, 100, 100}), 0);
  fuse_flow::LumaBlur nowhere(0.0f);
  for (int k = -2; k <= 2; ++k) nowhere.add(k, 2.0f, 100.0f);
  EXPECT_LT(nowhere.mean(), 0);
}

}  // namespace
