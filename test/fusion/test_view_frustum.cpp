#include <fuse_flow/impl/sensors/rig_geometry.hpp>

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

// Whole cells that a view cannot see are not asked about: a cell wrongly left out would lose what a view says of it.

namespace {

using fuse_flow::Camera;
using fuse_flow::Vec3;
using fuse_flow::host::Bounds;
using fuse_flow::host::ViewGeometry;

Camera idealCamera() {
  Camera camera;
  camera.intrinsics = {160, 120, 150, 140, 70.3f, 66.1f, {}};
  return camera;
}

Camera barrelCamera() {
  Camera camera = idealCamera();
  camera.intrinsics.distortion = {-0.28f, 0.07f, 4e-4f, -3e-4f, 0, 0, 0, 0};
  return camera;
}

ViewGeometry geometry(const Camera& camera) {
  ViewGeometry view;
  view.assign(camera);
  return view;
}

bool sees(const ViewGeometry& view, const Vec3& p) {
  float x = 0, y = 0, z = 0;
  return view.locate(p, x, y, z);
}

TEST(ViewFrustum, NoPointThatAViewSeesIsInABoxThatItDoesNot) {
  std::mt19937 random(7);
  const auto within = [&random](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (const double away : {0.0, 30.0, 1000.0})  // metres from the world's origin: rounding grows with it
    for (Camera camera : {idealCamera(), barrelCamera()}) {
      int seen = 0, left_out = 0;
      for (int pose = 0; pose < 50; ++pose) {
        const Eigen::Vector3d axis(within(-1, 1), within(-1, 1), within(0.1, 1));
        camera.T_world_camera = Eigen::Translation3d(away + within(-1, 1), away + within(-1, 1), within(-1, 1)) *
                                Eigen::AngleAxisd(within(-3, 3), axis.normalized());
        const ViewGeometry view = geometry(camera);
        for (int k = 0; k < 200; ++k) {
          const float half = static_cast<float>(std::exp(within(-6, 0)));
          const Eigen::Vector3f c =
              (camera.T_world_camera.translation() + Eigen::Vector3d(within(-4, 4), within(-4, 4), within(-4, 4)))
                  .cast<float>();
          const Bounds box{{c.x(), c.y(), c.z()}, {half, 0.5f * half, half}};
          const bool shown = view.frustum.mayShow(box);
          left_out += shown ? 0 : 1;
          for (int point = 0; point < 30; ++point) {
            const auto off = [&](float side) { return side * static_cast<float>(within(-1, 1)); };
            const Vec3 p = box.centre + Vec3{off(box.half.x), off(box.half.y), off(box.half.z)};
            if (!sees(view, p)) continue;
            ++seen;
            ASSERT_TRUE(shown) << "at (" << p.x << ", " << p.y << ", " << p.z << "), " << away << " m away";
          }
        }
      }
      EXPECT_GT(seen, 10000);
      EXPECT_GT(left_out, 5000);  // of 10,000: most of the directions are none of the view's
    }
}

TEST(ViewFrustum, LeavesOutWhatIsBehindTheCameraOrBesideTheImage) {
  const ViewGeometry view = geometry(idealCamera());
  const auto mayShow = [&](float x, float y, float z) {
    return view.frustum.mayShow({{x, y, z}, {0.032f, 0.032f, 0.032f}});
  };
  EXPECT_TRUE(mayShow(0, 0, 2));
  EXPECT_TRUE(mayShow(0, 0, 0));  // the camera's centre is in it
  EXPECT_FALSE(mayShow(0, 0, -0.04f));
  // At 2 m a pixel is 13.3 mm wide and 14.3 mm high: the image's borders are at x = −0.944 and 1.189 m, and y = −0.951 and 0.763 m.
  for (const bool out : {false, true}) {
    const float by = out ? 0.08f : 0.02f;  // half a box and some are 61 mm along the slanted planes
    EXPECT_EQ(mayShow(-0.944f - by, 0, 2), !out);
    EXPECT_EQ(mayShow(1.189f + by, 0, 2), !out);
    EXPECT_EQ(mayShow(0, -0.951f - by, 2), !out);
    EXPECT_EQ(mayShow(0, 0.763f + by, 2), !out);
  }
}

TEST(ViewFrustum, OfALensWithDistortionIsThatOfItsWidestRay) {
  const ViewGeometry view = geometry(barrelCamera());
  const float widest = std::sqrt(view.max_squared_radius);
  const auto mayShow = [&](float x, float y) { return view.frustum.mayShow({{x, y, 2}, {0.01f, 0.01f, 0.01f}}); };
  for (const float sign : {-1.0f, 1.0f}) {
    EXPECT_TRUE(mayShow(sign * 2 * widest, 0));
    EXPECT_TRUE(mayShow(0, sign * 2 * widest));
    EXPECT_FALSE(mayShow(sign * 2.2f * widest, 0));
    EXPECT_FALSE(mayShow(0, sign * 2.2f * widest));
  }
}

TEST(ViewFrustum, FollowsTheCameraWhenItMoves) {
  Camera camera = idealCamera();
  ViewGeometry view = geometry(camera);
  const Bounds box{{0, 0, 2}, {0.03f, 0.03f, 0.03f}};
  EXPECT_TRUE(view.frustum.mayShow(box));
  camera.T_world_camera.linear() = Eigen::AngleAxisd(1.5, Eigen::Vector3d::UnitY()).toRotationMatrix();
  view.assign(camera);  // the same lens
  EXPECT_FALSE(view.frustum.mayShow(box));
}

}  // namespace
