#include "viewer/fusing/coloring.h"
#include "wall_source.h"

#include <gtest/gtest.h>

namespace viewer_test {
namespace {

using namespace viewing;

PointFused pointAt(float x, float y, float z) {
  PointFused p;
  p.x = x;
  p.y = y;
  p.z = z;
  return p;
}

bool operator==(const Rgb8& a, const Rgb8& b) { return a.r == b.r && a.g == b.g && a.b == b.b; }

io::LoadedFrame wall() {
  io::LoadedFrame frame;
  WallSource().read(0, frame);
  return frame;
}

TEST(Coloring, RgbIsThePointsOwn) {
  Cloud cloud;
  cloud.push_back(pointAt(0, 0, 1));
  cloud[0].r = 10;
  cloud[0].g = 20;
  cloud[0].b = 30;
  EXPECT_TRUE(colorsOf(cloud, ColorBy::Rgb, {})[0] == (Rgb8{10, 20, 30}));
}

TEST(Coloring, ConfidenceAndViewsChangeTheColorAndDoNothingElse) {
  Cloud cloud;
  for (int k = 0; k < 2; ++k) cloud.push_back(pointAt(0, 0, 1));
  cloud[0].confidence = 0.1f;
  cloud[1].confidence = 0.9f;
  cloud[0].view_count = cloud[1].view_count = 2;
  EXPECT_FALSE(colorsOf(cloud, ColorBy::Confidence, {})[0] == colorsOf(cloud, ColorBy::Confidence, {})[1]);
  EXPECT_TRUE(colorsOf(cloud, ColorBy::Views, {})[0] == colorsOf(cloud, ColorBy::Views, {})[1]);
  cloud[1].view_count = 1;
  EXPECT_FALSE(colorsOf(cloud, ColorBy::Views, {})[0] == colorsOf(cloud, ColorBy::Views, {})[1]);
}

TEST(Coloring, OfAMethodThatHasNoConfidenceOrCountsNoCamerasItIsGrey) {
  Cloud cloud;
  cloud.push_back(pointAt(0, 0, 1));
  cloud[0].confidence = 1;
  cloud[0].view_count = 1;
  PointAttributes attributes;
  attributes.confidence_known = attributes.views_known = false;
  for (const ColorBy what : {ColorBy::Confidence, ColorBy::Views}) {
    EXPECT_FALSE(colorsOf(cloud, what, {})[0] == (Rgb8{128, 128, 128}));
    EXPECT_TRUE(colorsOf(cloud, what, attributes)[0] == (Rgb8{128, 128, 128}));
  }
}

TEST(Coloring, TruthGoesFromBlueOnTheSurfaceToRedAtTheLimit) {
  Cloud cloud;
  for (int k = 0; k < 3; ++k) cloud.push_back(pointAt(0, 0, 1));
  PointAttributes attributes;
  attributes.truth_distances = {0, kTruthLimit, std::numeric_limits<float>::infinity()};
  const std::vector<Rgb8> colors = colorsOf(cloud, ColorBy::TruthDistance, attributes);
  EXPECT_GT(colors[0].b, colors[0].r);
  EXPECT_GT(colors[1].r, colors[1].b);
  EXPECT_TRUE(colors[1] == colors[2]) << "far off is red, not unknown";
}

TEST(Coloring, WhatIsNotKnownIsGrey) {
  Cloud cloud;
  cloud.push_back(pointAt(0, 0, 1));
  for (const ColorBy what : {ColorBy::Camera, ColorBy::TruthDistance, ColorBy::Normal}) {
    const Rgb8 color = colorsOf(cloud, what, {})[0];
    EXPECT_TRUE(color.r == color.g && color.g == color.b);
  }
}

TEST(Coloring, EveryLegendNamesWhatItsColorsAre) {
  EXPECT_TRUE(legendOf(ColorBy::Rgb, {}).colors.empty());
  EXPECT_EQ(legendOf(ColorBy::Camera, {"left", "right"}).labels, (std::vector<std::string>{"left", "right"}));
  EXPECT_TRUE(legendOf(ColorBy::Camera, {"left", "right"}).colors[1] == cameraColor(1));
  EXPECT_NEAR(legendOf(ColorBy::TruthDistance, {}).high, 20.0, 1e-3) << "millimetres";
}

TEST(PointAttributes, TheCameraOfOriginIsTheOneThatMeasuredThePoint) {
  const io::LoadedFrame frame = wall();
  Cloud cloud;
  cloud.push_back(pointAt(-0.85f, 0, 2));       // only the left camera reaches that far
  cloud.push_back(pointAt(0.853f, 0.203f, 2));  // only the right one
  cloud.push_back(pointAt(0, 0, 2 - 0.051f));   // nobody measured within 50 mm
  const std::vector<Origin> origins = originsOf(cloud, frame.rig, 2);
  EXPECT_EQ(origins[0].camera, 0u);
  EXPECT_EQ(origins[1].camera, 1u);
  EXPECT_EQ(origins[2].camera, Origin::kNone);
  // 10 mm a pixel: 75.3 right of its middle at 79.5, 20.3 below its middle at 59.5.
  EXPECT_EQ(origins[1].u, 155);
  EXPECT_EQ(origins[1].v, 80);
}

TEST(PointAttributes, OfTwoCamerasTheNearerMeasurementWins) {
  io::LoadedFrame frame = wall();
  for (float& z : frame.images[0].depth32.data) z = 1.98f;
  Cloud cloud;
  cloud.push_back(pointAt(0, 0, 1.985f));
  cloud.push_back(pointAt(0, 0, 1.995f));
  const std::vector<Origin> origins = originsOf(cloud, frame.rig, 1);
  EXPECT_EQ(origins[0].camera, 0u);
  EXPECT_EQ(origins[1].camera, 1u);
}

TEST(PointAttributes, TheNormalOfAWallFacesTheCamera) {
  const io::LoadedFrame frame = wall();
  Cloud cloud;
  cloud.push_back(pointAt(0, 0, 2));
  cloud.push_back(pointAt(0, 0, 1));
  const std::vector<Eigen::Vector3f> normals = normalsOf(originsOf(cloud, frame.rig, 1), frame.rig, 1);
  EXPECT_NEAR(normals[0].z(), -1, 0.01);
  EXPECT_EQ(normals[1].norm(), 0) << "of a point that no camera measured nothing is known";
}

TEST(PointAttributes, AMissingCameraIsNoOrigin) {
  io::LoadedFrame frame = wall();
  frame.rig.views[0] = {};
  Cloud cloud;
  cloud.push_back(pointAt(-0.85f, 0, 2));
  cloud.push_back(pointAt(0, 0, 2));
  const std::vector<Origin> origins = originsOf(cloud, frame.rig, 1);
  EXPECT_EQ(origins[0].camera, Origin::kNone);
  EXPECT_EQ(origins[1].camera, 1u);
}

}  // namespace
}  // namespace viewer_test
