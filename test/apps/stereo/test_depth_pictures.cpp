#include "stereo/depth_pictures.h"

#include <gtest/gtest.h>

namespace {

using namespace fuse_flow;

TEST(DepthPictures, AreBrightNearAndDarkFarAndBlackWhereNothingIs) {
  io::FloatImage depth;
  depth.resize(3, 1);
  depth.data = {1, 4, 0};
  const io::ColorImage picture = io::depthPicture(depth, {1, 4});
  EXPECT_GT(picture.at(0, 0).r, 200);  // yellow
  EXPECT_GT(picture.at(0, 0).g, 200);
  EXPECT_LT(picture.at(1, 0).g, 40);  // dark blue
  EXPECT_GT(picture.at(1, 0).b, picture.at(1, 0).g);
  EXPECT_EQ(picture.at(2, 0).r + picture.at(2, 0).g + picture.at(2, 0).b, 0);
}

TEST(DepthPictures, OfOneDepthOrNoneCanBeDrawn) {
  io::FloatImage depth;
  depth.resize(2, 1);
  depth.data = {2, 0};
  EXPECT_EQ(io::depthPicture(depth, {2, 2}).at(1, 0).b, 0);
  depth.data = {0, 0};
  EXPECT_EQ(io::depthPicture(depth, {}).at(0, 0).b, 0);
}

TEST(DepthPictures, TheRangeIsThatOfDepthOnWhichOthersAgree) {
  io::LoadedFrame frame;
  frame.images.resize(2);
  frame.rig.views.resize(2);
  for (int k = 0; k < 2; ++k) {
    io::LoadedView& images = frame.images[static_cast<std::size_t>(k)];
    images.depth32.resize(3, 1);
    images.depth32.data = {1.0f + static_cast<float>(k), 2.0f + static_cast<float>(k), 90};
    images.confidence.resize(3, 1);
    images.confidence.data = {0.5f, 1, 0};
    frame.rig.views[static_cast<std::size_t>(k)].depth32 = images.depth32.view();
  }
  const io::PictureRange both = io::pictureRange(frame, {true, true}), one = io::pictureRange(frame, {false, true});
  EXPECT_EQ(both.nearest, 1);
  EXPECT_LT(both.farthest, 4);
  EXPECT_EQ(one.nearest, 2);
  frame.images[1].confidence.data = {0, 0, 0};
  EXPECT_EQ(io::pictureRange(frame, {false, true}).nearest, 2);
  EXPECT_EQ(io::pictureRange(frame, {false, false}).farthest, 0);
}

TEST(DepthPictures, ConfidenceIsGrey) {
  io::FloatImage confidence;
  confidence.resize(3, 1);
  confidence.data = {0, 1, 0.2f};
  const io::ColorImage picture = io::confidencePicture(confidence);
  EXPECT_EQ(picture.at(0, 0).r, 0);
  EXPECT_EQ(picture.at(1, 0).g, 255);
  EXPECT_EQ(picture.at(2, 0).b, 51);
}

}  // namespace
