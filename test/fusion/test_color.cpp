#include "../scenes.h"

#include <fuse_flow/filters/depth_backprojection.h>

#include <pcl/point_types.h>

namespace {

using scenes::Scene;

/** \brief An image whose red is the column and whose green is the row. */
fuse_flow::io::ColorImage ruler(int width, int height) {
  fuse_flow::io::ColorImage image;
  image.resize(width, height);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u)
      image.data[static_cast<std::size_t>(v * width + u)] = {static_cast<std::uint8_t>(u), static_cast<std::uint8_t>(v),
                                                             7};
  return image;
}

/** \brief A colour camera beside and before the depth camera, turned about all axes. */
fuse_flow::ColorCamera turnedColorCamera(int width, int height, float focal) {
  fuse_flow::ColorCamera camera;
  camera.intrinsics = scenes::lookAt({0, 0, 0}, {0, 0, 1}, width, height, focal).intrinsics;
  camera.T_depth_color.translation() << 0.06, -0.03, 0.02;
  camera.T_depth_color.linear() =
      (Eigen::AngleAxisd(0.08, Eigen::Vector3d::UnitX()) * Eigen::AngleAxisd(-0.11, Eigen::Vector3d::UnitY()) *
       Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitZ()))
          .toRotationMatrix();
  return camera;
}

/** \brief Where pixel (u, v) of a wall z metres away is in the colour image, in double precision and of an ideal lens. */
Eigen::Vector2d inColorImage(const fuse_flow::Camera& camera, int u, int v, double z) {
  const fuse_flow::Intrinsics& K = camera.intrinsics;
  const fuse_flow::Intrinsics& Kc = camera.color->intrinsics;
  const Eigen::Vector3d p((u - static_cast<double>(K.cx)) / static_cast<double>(K.fx) * z,
                          (v - static_cast<double>(K.cy)) / static_cast<double>(K.fy) * z, z);
  const Eigen::Vector3d q = camera.color->T_depth_color.inverse() * p;
  return {static_cast<double>(Kc.fx) * q.x() / q.z() + static_cast<double>(Kc.cx),
          static_cast<double>(Kc.fy) * q.y() / q.z() + static_cast<double>(Kc.cy)};
}

pcl::PointCloud<pcl::PointXYZRGB> backproject(const fuse_flow::Camera& camera, const fuse_flow::DepthView& view) {
  fuse_flow::DepthBackprojection<pcl::PointXYZRGB> filter;
  filter.setCamera(camera);
  filter.setView(view);
  pcl::PointCloud<pcl::PointXYZRGB> cloud;
  filter.filter(cloud);
  return cloud;
}

/** \brief Two cameras of one pose before a flat wall, in two colours. */
Scene twoColors(const fuse_flow::Rgb8& first, const fuse_flow::Rgb8& second) {
  Scene scene = scenes::makeFlatScene(scenes::sameCameras(2, 20, 20, 40), {1.0f, 1.0f});
  scene.paint(second);
  std::fill(scene.color[0].data.begin(), scene.color[0].data.end(), first);
  return scene;
}

void expectColor(const scenes::Cloud& cloud, int r, int g, int b) {
  ASSERT_FALSE(cloud.empty());
  for (const auto& point : cloud) {
    ASSERT_EQ(point.r, r);
    ASSERT_EQ(point.g, g);
    ASSERT_EQ(point.b, b);
  }
}

}  // namespace

TEST(Color, ComesFromWhereTheColorCameraSeesThePoint) {
  constexpr double kDistance = 1.25;
  Scene scene = scenes::makeFlatScene(scenes::sameCameras(1, 40, 30, 60), {static_cast<float>(kDistance)});
  fuse_flow::Camera& camera = scene.rig.cameras[0];
  camera.color = turnedColorCamera(200, 160, 130);
  scene.color.push_back(ruler(200, 160));
  scene.attach();
  const auto cloud = backproject(camera, scene.rig.views[0]);
  std::size_t compared = 0;
  for (int v = 0; v < 30; ++v)
    for (int u = 0; u < 40; ++u) {
      const Eigen::Vector2d expected = inColorImage(camera, u, v, kDistance);
      ASSERT_TRUE(expected.minCoeff() > 0 && expected.x() < 199 && expected.y() < 159) << "the test's own geometry";
      const pcl::PointXYZRGB& point = cloud(static_cast<std::size_t>(u), static_cast<std::size_t>(v));
      ASSERT_NEAR(point.r, expected.x(), 0.501);
      ASSERT_NEAR(point.g, expected.y(), 0.501);
      ASSERT_EQ(point.b, 7);
      ++compared;
    }
  EXPECT_EQ(compared, 1200u);
}

TEST(Color, IsNotThatOfTheBorderFarOutsideTheColorImage) {
  constexpr double kDistance = 1.25;
  Scene scene = scenes::makeFlatScene(scenes::sameCameras(1, 40, 30, 60), {static_cast<float>(kDistance)});
  fuse_flow::Camera& camera = scene.rig.cameras[0];
  camera.color = turnedColorCamera(40, 30, 130);  // a third of the depth camera's field of view
  scene.color.push_back(ruler(40, 30));
  scene.attach();
  const auto cloud = backproject(camera, scene.rig.views[0]);
  std::size_t inside = 0, outside = 0;
  for (int v = 0; v < 30; ++v)
    for (int u = 0; u < 40; ++u) {
      const Eigen::Vector2d p = inColorImage(camera, u, v, kDistance);
      const pcl::PointXYZRGB& point = cloud(static_cast<std::size_t>(u), static_cast<std::size_t>(v));
      if (p.x() > -0.5 && p.x() < 39.5 && p.y() > -0.5 && p.y() < 29.5) {
        ASSERT_EQ(point.b, 7);
        ++inside;
      } else if (p.x() < -1.51 || p.x() > 40.51 || p.y() < -1.51 || p.y() > 30.51) {
        ASSERT_EQ(point.rgba & 0xffffffu, 0u) << "black";
        ++outside;
      }
    }
  EXPECT_GT(inside, 50u);
  EXPECT_GT(outside, 600u);
}

TEST(Color, IsNotReadWhereALensFoldsBackIntoItsImage) {
  // r (1 − 0.3 r²) rises up to r = 1.05 and falls back to zero at 1.83: a point 61° off the axis seems to be near the middle.
  Scene scene = scenes::makeFlatScene(scenes::sameCameras(1, 101, 3, 25), {1.0f});
  fuse_flow::Camera& camera = scene.rig.cameras[0];
  camera.color.emplace();
  camera.color->intrinsics = scenes::lookAt({0, 0, 0}, {0, 0, 1}, 61, 61, 60).intrinsics;
  camera.color->intrinsics.distortion.k1 = -0.3f;
  scene.color.push_back(ruler(61, 61));
  scene.attach();
  const auto cloud = backproject(camera, scene.rig.views[0]);
  EXPECT_EQ(cloud(50, 1).b, 7);                 // on the axis
  EXPECT_EQ(cloud(5, 1).rgba & 0xffffffu, 0u);  // r = 1.8
  EXPECT_EQ(cloud(95, 1).rgba & 0xffffffu, 0u);
}

/** \brief A wall 2 m away, and before its middle a square of another colour at 0.8 m, for a depth camera whose colour camera stands
 *  baseline metres to the right. What each of them sees is known by hand: both surfaces are parallel to the images. */
struct HiddenWall {
  static constexpr double kWall = 2.0, kSquare = 0.8, kHalf = 0.15;
  double baseline;
  Scene scene{
      scenes::makeScene(scenes::sameCameras(1, 160, 120, 130),
                        scenes::nearest({scenes::square(0, 0, kSquare, kHalf), scenes::plane({0, 0, 1}, kWall)}))};

  explicit HiddenWall(double metres) : baseline(metres) {
    fuse_flow::Camera& camera = scene.rig.cameras[0];
    camera.color.emplace();
    camera.color->intrinsics = scenes::lookAt({0, 0, 0}, {0, 0, 1}, 640, 480, 520).intrinsics;
    camera.color->T_depth_color.translation().x() = baseline;
    scene.color.emplace_back();
    fuse_flow::io::ColorImage& image = scene.color[0];
    image.resize(640, 480);
    const fuse_flow::Intrinsics& K = camera.color->intrinsics;
    for (int v = 0; v < 480; ++v)
      for (int u = 0; u < 640; ++u) {
        const double x = kSquare * (u - static_cast<double>(K.cx)) / static_cast<double>(K.fx) + baseline;
        const double y = kSquare * (v - static_cast<double>(K.cy)) / static_cast<double>(K.fy);
        const bool square = std::abs(x) < kHalf && std::abs(y) < kHalf;
        image.data[static_cast<std::size_t>(v * 640 + u)] = square ? blue : red;
      }
    scene.attach();
  }
  /** \brief Whether the square stands between a point of the wall and the colour camera. */
  bool hidden(double x, double y) const {
    const double share = kSquare / kWall;  // of the way from the camera
    return std::abs(baseline + share * (x - baseline)) < kHalf && std::abs(share * y) < kHalf;
  }

  const fuse_flow::Rgb8 red{200, 40, 40}, blue{40, 40, 200};
};

TEST(Color, OfWhatIsHiddenFromTheColorCameraIsNotThatOfWhatHidesIt) {
  for (const double baseline : {0.015, 0.032, 0.052, -0.052}) {
    const HiddenWall wall(baseline);
    const auto cloud = backproject(wall.scene.rig.cameras[0], wall.scene.rig.views[0]);
    std::size_t hidden = 0, wrong = 0, seen = 0, red = 0, square = 0, blue = 0;
    for (const pcl::PointXYZRGB& point : cloud) {
      const bool is_red = point.r == 200 && point.b == 40, is_blue = point.r == 40 && point.b == 200;
      if (point.z < 1) {
        ++square;
        blue += is_blue ? 1 : 0;
      } else if (wall.hidden(static_cast<double>(point.x), static_cast<double>(point.y))) {
        ++hidden;
        wrong += is_blue ? 1 : 0;
      } else {
        ++seen;
        red += is_red ? 1 : 0;
      }
    }
    ASSERT_GT(hidden, 80u) << "the test's own geometry";
    EXPECT_LE(static_cast<double>(wrong), 0.05 * static_cast<double>(hidden)) << baseline;
    EXPECT_GE(static_cast<double>(red), 0.97 * static_cast<double>(seen)) << baseline;
    EXPECT_GE(static_cast<double>(blue), 0.99 * static_cast<double>(square)) << baseline;
  }
}

TEST(Color, OfAFusedPointIsNotThatOfWhatHidesIt) {
  HiddenWall wall(0.052);
  std::size_t hidden = 0, wrong = 0;
  for (const auto& point : scenes::fuse(wall.scene.rig)) {
    if (point.z < 1 || !wall.hidden(static_cast<double>(point.x), static_cast<double>(point.y))) continue;
    ++hidden;
    wrong += point.b > 100 ? 1 : 0;
  }
  ASSERT_GT(hidden, 50u);
  EXPECT_LE(static_cast<double>(wrong), 0.05 * static_cast<double>(hidden));
}

TEST(Color, OfASlantedSurfaceHidesNothingOfItself) {
  // At 60 to over 80 degrees from straight on, of which sensors measure up to some 75.
  const Eigen::Vector3d normal = Eigen::Vector3d(3.73, 0, 1).normalized();
  Scene scene = scenes::makeScene(scenes::sameCameras(1, 160, 120, 130), scenes::plane({3.73, 0, 1}, 1.2));
  fuse_flow::Camera& camera = scene.rig.cameras[0];
  camera.color.emplace();
  camera.color->intrinsics = scenes::lookAt({0, 0, 0}, {0, 0, 1}, 640, 480, 400).intrinsics;
  camera.color->T_depth_color.translation() << -0.03, 0.01, 0;
  scene.color.emplace_back();
  scene.color[0].resize(640, 480);
  std::fill(scene.color[0].data.begin(), scene.color[0].data.end(), fuse_flow::Rgb8{9, 99, 199});
  scene.attach();
  std::size_t points = 0, colored = 0;
  for (const pcl::PointXYZRGB& point : backproject(camera, scene.rig.views[0])) {
    const Eigen::Vector3d p = point.getVector3fMap().cast<double>();
    if (!p.allFinite() || normal.dot(p.normalized()) < std::cos(75 * M_PI / 180)) continue;
    ++points;
    colored += point.b == 199 ? 1 : 0;
  }
  ASSERT_GT(points, 3000u);
  EXPECT_GE(static_cast<double>(colored), 0.99 * static_cast<double>(points));
}

TEST(Color, OfAPointIsThatOfTheCamerasThatHaveOne) {
  Scene scene = twoColors({200, 100, 30}, {});
  scene.rig.views[1].color = {};
  expectColor(scenes::fuse(scene.rig), 200, 100, 30);
}

TEST(Color, OfAPointLeavesOutColorCamerasThatDoNotSeeIt) {
  Scene scene = twoColors({200, 100, 30}, {10, 20, 250});
  scene.rig.cameras[1].color.emplace();
  scene.rig.cameras[1].color->intrinsics = scene.rig.cameras[1].intrinsics;
  scene.rig.cameras[1].color->T_depth_color.translation().x() = 5;
  expectColor(scenes::fuse(scene.rig), 200, 100, 30);
}

TEST(Color, IsBlackWhereNoCameraHasOne) {
  Scene scene = twoColors({200, 100, 30}, {10, 20, 250});
  for (fuse_flow::DepthView& view : scene.rig.views) view.color = {};
  expectColor(scenes::fuse(scene.rig), 0, 0, 0);
}
