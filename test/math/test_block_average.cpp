#include <fuse_flow/math/calibration/block_average.h>

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

/** \brief The middle of 3×3 inverse depths, despeckled. */
float despeckled(const float (&q)[9], float bound = 0.5f) { return fuse_flow::despeckledInverseDepth(q, bound); }

TEST(DespeckledInverseDepth, APlaneStaysHoweverItIsInclined) {
  EXPECT_EQ(despeckled({1, 1, 1, 1, 1, 1, 1, 1, 1}), 1);
  EXPECT_EQ(despeckled({0.5f, 0.75f, 1, 0.75f, 1, 1.25f, 1, 1.25f, 1.5f}), 1);
}

TEST(DespeckledInverseDepth, WhatSticksOutOnAllSidesGoesBackToTheNearestMean) {
  EXPECT_EQ(despeckled({1, 1, 1, 1, 1.25f, 1, 1, 1, 1}), 1) << "to the front";
  EXPECT_EQ(despeckled({1, 1, 1, 1, 0.75f, 1, 1, 1, 1}), 1) << "to the back";
  EXPECT_EQ(despeckled({1, 1, 1, 1.125f, 1.25f, 1.125f, 1, 1, 1}), 1.125f) << "the row agrees most";
  EXPECT_EQ(despeckled({0.5f, 0.75f, 1, 0.75f, 1.25f, 1.25f, 1, 1.25f, 1.5f}), 1) << "of an inclined plane";
}

TEST(DespeckledInverseDepth, WhatGoesOnInOneDirectionStays) {
  EXPECT_EQ(despeckled({1, 1.25f, 1, 1, 1.25f, 1, 1, 1.25f, 1}), 1.25f) << "a ridge";
  EXPECT_EQ(despeckled({1, 1, 1, 1.25f, 1.25f, 1.25f, 1, 1, 1}), 1.25f) << "a ridge the other way";
  EXPECT_EQ(despeckled({1.25f, 1, 0.75f, 1.25f, 1, 0.75f, 0.75f, 1, 1.25f}), 1) << "between its neighbours' means";
}

// Else a block on a silhouette that has a step would come to lie between the surface and what is behind it.
TEST(DespeckledInverseDepth, PairsAcrossAJumpDoNotCount) {
  EXPECT_EQ(despeckled({1, 1, 1, 3, 3, 1, 3, 3, 3}, 0.5f), 3) << "a step";
  EXPECT_EQ(despeckled({1, 1, 1, 1, 3, 1, 1, 1, 1}, 0.5f), 3) << "nothing beside it";
  EXPECT_EQ(despeckled({1, 1, 1, 3, 3.25f, 3, 3, 3, 3}, 0.5f), 3.25f) << "one pair is no surface";
  EXPECT_EQ(despeckled({3, 1, 1, 3, 3.25f, 3, 3, 3, 3}, 0.5f), 3) << "two are";
}

TEST(DespeckledInverseDepth, HolesDoNotCount) {
  EXPECT_EQ(despeckled({0, 0, 0, 0, 1.25f, 0, 0, 0, 0}, 9), 1.25f);
  EXPECT_EQ(despeckled({0, 0, 0, 1, 1.25f, 1, 1, 1, 1}, 9), 1.25f) << "one pair";
  EXPECT_EQ(despeckled({0, 1, 0, 1, 1.25f, 1, 1, 1, 1}, 9), 1) << "two pairs";
}

}  // namespace
