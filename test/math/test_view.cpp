#include <fuse_flow/math/view.h>

#include <gtest/gtest.h>

#include <cmath>

namespace {

using namespace fuse_flow;

TEST(ViewModelPlace, TheFirstPixelBeginsHalfAPixelBeforeItsCentreAndTheLastEndsHalfAPixelBehind) {
  const Intrinsics K{8, 4, 1, 1, 0, 0, {}};
  const auto inside = [&K](float u, float v, float z = 2) {
    float x = 0, y = 0;
    return ViewModel::place({u * z, v * z, z}, K, x, y);
  };
  EXPECT_TRUE(inside(-0.5f, 0));
  EXPECT_TRUE(inside(0, -0.5f));
  EXPECT_FALSE(inside(-0.5001f, 0));
  EXPECT_FALSE(inside(0, -0.5001f));
  EXPECT_TRUE(inside(7.4999f, 3.4999f));
  EXPECT_FALSE(inside(7.5f, 0));
  EXPECT_FALSE(inside(0, 3.5f));
  EXPECT_FALSE(inside(1, 1, -2)) << "behind the camera";
}

TEST(Luminance, IsRec601) {
  EXPECT_FLOAT_EQ(luminance({100, 0, 0}), 29.9f);
  EXPECT_FLOAT_EQ(luminance({0, 100, 0}), 58.7f);
  EXPECT_FLOAT_EQ(luminance({0, 0, 100}), 11.4f);
  EXPECT_FLOAT_EQ(luminance({255, 255, 255}), 255);
}

TEST(IntensityMean, LeavesOutWhatIsNotKnown) {
  IntensityMean mean;
  EXPECT_TRUE(std::isnan(mean.mean()));
  mean.add(1, NAN);
  mean.add(1, INFINITY);
  EXPECT_TRUE(std::isnan(mean.mean()));
  mean.add(1, 10);
  mean.add(3, 2);
  EXPECT_EQ(mean.mean(), 4);
}

TEST(PixelColor, IsThatOfItsRowAndColumn) {
  const Rgb8 pixels[6] = {{0, 1, 2}, {3, 4, 5}, {6, 7, 8}, {9, 10, 11}, {12, 13, 14}, {15, 16, 17}};
  const ImageView<Rgb8> image(pixels, 3, 2);
  const ViewColor color = pixelColor(image, 1, 1);
  EXPECT_EQ(color.rgb.x, 12);
  EXPECT_EQ(color.rgb.y, 13);
  EXPECT_EQ(color.rgb.z, 14);
  EXPECT_TRUE(color.known);
  EXPECT_FALSE(pixelColor({}, 0, 0).known);
}

}  // namespace
