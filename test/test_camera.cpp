#include "refusal.h"

#include <fuse_flow/camera.h>
#include <fuse_flow/rig_frame.h>

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

namespace {

using namespace fuse_flow;
using refusal::expectMentions;
using refusal::messageOf;

Camera goodCamera(const std::string& name = "front-left") {
  Camera camera;
  camera.name = name;
  camera.intrinsics.width = 4;
  camera.intrinsics.height = 3;
  camera.intrinsics.fx = camera.intrinsics.fy = 5;
  camera.intrinsics.cx = 1.5f;
  camera.intrinsics.cy = 1;
  return camera;
}

std::string complaint(const std::function<void(Camera&)>& spoil) {
  Camera camera = goodCamera();
  spoil(camera);
  return messageOf([&] { checkCamera(camera); });
}

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

TEST(Camera, AcceptsAGoodCamera) { EXPECT_NO_THROW(checkCamera(goodCamera())); }

TEST(Camera, NamesTheCameraAndAZeroFocalLength) {
  expectMentions(complaint([](Camera& c) { c.intrinsics.fx = 0; }), {"front-left", "fx is 0"});
  expectMentions(complaint([](Camera& c) { c.intrinsics.fy = -2; }), {"front-left", "fy is -2"});
}

TEST(Camera, NamesTheCameraAndANumberThatIsNotFinite) {
  expectMentions(complaint([](Camera& c) { c.intrinsics.fx = kNaN; }), {"front-left", "fx is nan"});
  expectMentions(complaint([](Camera& c) { c.intrinsics.fy = kInf; }), {"front-left", "fy is inf"});
  expectMentions(complaint([](Camera& c) { c.intrinsics.cx = kNaN; }), {"front-left", "cx is nan"});
  expectMentions(complaint([](Camera& c) { c.intrinsics.cy = -kInf; }), {"front-left", "cy is -inf"});
}

TEST(Camera, NamesTheCameraAndTheImageSize) {
  expectMentions(complaint([](Camera& c) { c.intrinsics.width = 0; }), {"front-left", "0x3"});
  expectMentions(complaint([](Camera& c) { c.intrinsics.height = -1; }), {"front-left", "4x-1"});
}

TEST(Camera, RejectsEveryDistortionCoefficientThatIsNotFinite) {
  for (int k = 0; k < 8; ++k) {
    const std::string message = complaint([k](Camera& c) {
      Distortion& d = c.intrinsics.distortion;
      float* const coefficients[] = {&d.k1, &d.k2, &d.p1, &d.p2, &d.k3, &d.k4, &d.k5, &d.k6};
      *coefficients[k] = kNaN;
    });
    expectMentions(message, {"front-left", "distortion", "nan"});
  }
}

TEST(Camera, RejectsAPoseThatScales) {
  expectMentions(complaint([](Camera& c) { c.T_world_camera.linear() *= 1.1; }),
                 {"front-left", "T_world_camera", "not rigid", "0.21"});  // 1.1² − 1
}

TEST(Camera, RejectsAPoseThatMirrors) {
  expectMentions(complaint([](Camera& c) { c.T_world_camera.linear()(2, 2) = -1; }),
                 {"front-left", "T_world_camera", "not rigid", "det R is -1"});
}

TEST(Camera, RejectsAPoseWithANumberThatIsNotFinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  expectMentions(complaint([nan](Camera& c) { c.T_world_camera.translation().y() = nan; }),
                 {"front-left", "T_world_camera"});
  expectMentions(complaint([nan](Camera& c) { c.T_world_camera.linear()(0, 1) = nan; }),
                 {"front-left", "T_world_camera"});
}

TEST(Camera, AcceptsARotationThatIsOnlyRoundedToFloat) {
  Camera camera = goodCamera();
  camera.T_world_camera.linear() =
      Eigen::AngleAxisf(0.3f, Eigen::Vector3f(1, 2, 3).normalized()).toRotationMatrix().cast<double>();
  EXPECT_NO_THROW(checkCamera(camera));
}

TEST(Camera, ChecksTheColourCameraAsWell) {
  expectMentions(complaint([](Camera& c) {
                   c.color.emplace();
                   c.color->intrinsics = c.intrinsics;
                   c.color->intrinsics.fx = 0;
                 }),
                 {"front-left", "color", "fx is 0"});
  expectMentions(complaint([](Camera& c) {
                   c.color.emplace();
                   c.color->intrinsics = c.intrinsics;
                   c.color->T_depth_color.linear()(0, 0) = -1;
                 }),
                 {"front-left", "color", "T_depth_color", "not rigid"});
}

TEST(Camera, SameCalibrationSeesEveryDifferenceThatMattersAndNoOther) {
  const Camera a = goodCamera("a");
  EXPECT_TRUE(sameCalibration(a, goodCamera("b")));
  Camera b = a;
  b.intrinsics.distortion.k6 = 0.1f;
  EXPECT_FALSE(sameCalibration(a, b));
  b = a;
  b.T_world_camera.translation().z() = 1e-9;
  EXPECT_FALSE(sameCalibration(a, b));
  b = a;
  b.color.emplace();
  EXPECT_FALSE(sameCalibration(a, b));
  Camera c = b;
  EXPECT_TRUE(sameCalibration(b, c));
  c.color->intrinsics.cx = 1;
  EXPECT_FALSE(sameCalibration(b, c));
}

class RigFrameCheck : public ::testing::Test {
 protected:
  RigFrameCheck() {
    frame.cameras = {goodCamera("left"), goodCamera("right")};
    frame.views.resize(2);
    for (DepthView& view : frame.views) view.depth32 = {metres.data(), 4, 3};
  }
  std::string complaint() const {
    return messageOf([this] { checkRigFrame(frame); });
  }

  std::vector<float> metres = std::vector<float>(20, 1.0f);
  std::vector<std::uint16_t> millimetres = std::vector<std::uint16_t>(20, 1000);
  std::vector<Rgb8> colors = std::vector<Rgb8>(20);
  RigFrame frame;
};

TEST_F(RigFrameCheck, AcceptsAGoodFrame) { EXPECT_NO_THROW(checkRigFrame(frame)); }

TEST_F(RigFrameCheck, AcceptsAMissingView) {
  frame.views[1] = {};
  EXPECT_NO_THROW(checkRigFrame(frame));
}

TEST_F(RigFrameCheck, RejectsAFrameWithoutCameras) {
  frame = {};
  expectMentions(complaint(), {"RigFrame", "no camera"});
}

TEST_F(RigFrameCheck, CountsCamerasAndViewsIfTheyDiffer) {
  frame.views.resize(3);
  expectMentions(complaint(), {"RigFrame", "2 cameras", "3 views"});
}

TEST_F(RigFrameCheck, NamesTheCameraWhoseDepthHasAnotherSize) {
  frame.views[1].depth32 = {metres.data(), 5, 3};
  expectMentions(complaint(), {"'right'", "depth", "5x3", "4x3"});
}

TEST_F(RigFrameCheck, NamesTheCameraWhoseColourHasAnotherSize) {
  frame.views[0].color = {colors.data(), 4, 4};
  expectMentions(complaint(), {"'left'", "color", "4x4", "4x3"});
}

TEST_F(RigFrameCheck, MeasuresColourByTheColourCameraWhereThereIsOne) {
  frame.cameras[0].color.emplace();
  frame.cameras[0].color->intrinsics = frame.cameras[0].intrinsics;
  frame.cameras[0].color->intrinsics.height = 4;
  frame.views[0].color = {colors.data(), 4, 4};
  EXPECT_NO_THROW(checkRigFrame(frame));
  frame.views[0].color = {colors.data(), 4, 3};
  expectMentions(complaint(), {"'left'", "color", "4x3", "4x4"});
}

TEST_F(RigFrameCheck, NamesTheCameraWhoseConfidenceHasAnotherSize) {
  frame.views[0].confidence = {metres.data(), 2, 3};
  expectMentions(complaint(), {"'left'", "confidence", "2x3", "4x3"});
}

TEST_F(RigFrameCheck, RejectsTwoDepthImagesOfOneView) {
  frame.views[1].depth16 = {millimetres.data(), 4, 3};
  expectMentions(complaint(), {"'right'", "depth16", "depth32"});
}

TEST_F(RigFrameCheck, NamesABadDepthScale) {
  frame.views[1] = {};
  frame.views[1].depth16 = {millimetres.data(), 4, 3};
  EXPECT_NO_THROW(checkRigFrame(frame));
  frame.cameras[1].depth_scale = 0;
  expectMentions(complaint(), {"'right'", "depth_scale is 0"});
  frame.cameras[1].depth_scale = kNaN;
  expectMentions(complaint(), {"'right'", "depth_scale is nan"});
}

TEST_F(RigFrameCheck, RejectsRowsThatOverlap) {
  frame.views[0].depth32 = {metres.data(), 4, 3, 12};
  expectMentions(complaint(), {"'left'", "12 bytes"});
}

TEST_F(RigFrameCheck, AcceptsPaddedRows) {
  frame.views[0].depth32 = {metres.data(), 4, 3, 24};
  EXPECT_NO_THROW(checkRigFrame(frame));
  EXPECT_EQ(frame.views[0].depth32.row(2), metres.data() + 12);
}

TEST_F(RigFrameCheck, ChecksEveryCameraEvenOfAMissingView) {
  frame.views[1] = {};
  frame.cameras[1].intrinsics.fx = 0;
  expectMentions(complaint(), {"'right'", "fx is 0"});
}

}  // namespace
