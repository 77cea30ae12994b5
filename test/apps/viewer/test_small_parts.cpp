#include "viewer/controls/status_text.h"
#include "viewer/fusing/thumbnail.h"
#include "viewer/world/drawn_point.h"
#include "viewer/world/frusta.h"
#include "viewer/world/viewpoint.h"
#include "wall_source.h"

#include <gtest/gtest.h>

namespace viewer_test {
namespace {

using namespace viewing;

TEST(Thumbnail, ShowsTheColorImageWhereThereIsOneElseTheDepthNearBright) {
  io::LoadedFrame frame;
  WallSource().read(0, frame);
  const io::ColorImage color = thumbnailOf(frame.rig.cameras[0], frame.rig.views[0], 30);
  EXPECT_EQ(color.width, 40);
  EXPECT_EQ(color.height, 30);
  EXPECT_EQ(color.at(0, 0).r, 200);
  EXPECT_EQ(color.at(39, 0).g, 30);
  frame.rig.views[0].color = {};
  for (int v = 0; v < WallSource::kHeight; ++v) frame.images[0].depth32.at(0, v) = 1;
  const io::ColorImage depth = thumbnailOf(frame.rig.cameras[0], frame.rig.views[0], 30);
  EXPECT_GT(depth.at(0, 0).r, depth.at(39, 0).r);
  EXPECT_TRUE(thumbnailOf(Camera(), DepthView(), 30).empty()) << "a missing camera";
}

TEST(Thumbnail, TheStripFitsAndSaysWhereEachPictureBegins) {
  io::ColorImage picture;
  picture.resize(80, 60);
  const Strip roomy = stripOf({picture, io::ColorImage(), picture}, 1000, 60);
  EXPECT_EQ(roomy.image.height, 60);
  EXPECT_EQ(roomy.image.width, 3 * 80) << "the missing one is as wide as the others";
  EXPECT_EQ(roomy.begin, (std::vector<int>{0, 80, 160}));
  EXPECT_EQ(roomy.image.at(81, 1).r, cameraColor(1).r) << "a border of the camera's colour";
  const Strip tight = stripOf({picture, io::ColorImage(), picture}, 120, 60);
  EXPECT_EQ(tight.image.height, 30);
  EXPECT_LE(tight.image.width, 120);
  EXPECT_EQ(stripOf({io::ColorImage()}, 1000, 60).image.width, 80);
}

TEST(Frusta, AnglesAndPlaceAreTheCameras) {
  const auto lines = frustumLines({WallSource::camera(0), WallSource::camera(1)}, 2);
  ASSERT_EQ(lines->GetNumberOfPoints(), 10);
  EXPECT_EQ(lines->GetNumberOfLines(), 16);
  EXPECT_NEAR(lines->GetPoint(5)[0], 0.1, 1e-6) << "where the right camera stands";
  // Its upper left corner: 79.5 and 59.5 pixels from the middle, 10 mm each at 2 m.
  EXPECT_NEAR(lines->GetPoint(6)[0], 0.1 - 0.795, 1e-5);
  EXPECT_NEAR(lines->GetPoint(6)[1], -0.595, 1e-5);
  EXPECT_NEAR(lines->GetPoint(6)[2], 2, 1e-5);
}

TEST(Viewpoint, LooksAtTheCloudFromTheCamerasSideAndUprightAsTheyAre) {
  Cloud cloud;
  for (int k = 0; k < 1001; ++k) {
    PointFused p;
    p.x = 0.001f * static_cast<float>(k - 500);
    p.z = 2;
    cloud.push_back(p);
  }
  cloud[0].z = 1000;  // one stray point moves nothing
  const Viewpoint view = startViewpoint(cloud, {WallSource::camera(0)});
  EXPECT_NEAR((view.at - Eigen::Vector3d(0, 0, 2)).norm(), 0, 0.01);
  EXPECT_NEAR(view.up.y(), -1, 1e-9) << "y points down";
  EXPECT_LT(view.from.z(), 2);
  EXPECT_LT(view.from.y(), 0) << "from above";
  EXPECT_LT((view.from - view.at).norm(), 3);
}

/** \brief A room 8 m wide, seen from cameras within it. */
TEST(Viewpoint, IsNotBehindTheWallsThatTheCamerasStandWithin) {
  Cloud room;
  for (int k = 0; k < 3600; ++k) {
    const double angle = k * M_PI / 1800;
    PointFused p;
    p.x = static_cast<float>(4 * std::cos(angle));
    p.y = static_cast<float>(4 * std::sin(angle));
    p.z = 0.001f * static_cast<float>(k % 1000);
    room.push_back(p);
  }
  const auto cameraAt = [](double x) {
    Camera camera = WallSource::camera(0);
    camera.T_world_camera.linear() << 0, 0, -1, -1, 0, 0, 0, -1, 0;  // looks along -x, upright
    camera.T_world_camera.translation() << x, 0, 1;
    return camera;
  };
  const Viewpoint within = startViewpoint(room, {cameraAt(3), cameraAt(-3)});
  EXPECT_LT((within.from - within.at).norm(), 3.2);
  EXPECT_GT(within.angle, 50);
  const Viewpoint outwards = startViewpoint(room, {cameraAt(0.3)});
  EXPECT_GT((outwards.from - outwards.at).norm(), 8) << "there is no place from which one sees more";
  EXPECT_NEAR(outwards.angle, 30, 2);
}

TEST(Viewpoint, ShowsAllOfABox) {
  Viewpoint view;
  view.from = {5, 0, 3};
  view.angle = 50;
  const Eigen::AlignedBox3d box(Eigen::Vector3d(-1, 2, 0), Eigen::Vector3d(1, 3, 0.5));
  const Viewpoint closer = lookingAtAllOf(box, view);
  EXPECT_TRUE(closer.at.isApprox(box.center()));
  const Eigen::Vector3d towards = (closer.at - closer.from).normalized();
  EXPECT_TRUE(towards.isApprox((view.at - view.from).normalized()));
  double widest = 0;
  for (int k = 0; k < 8; ++k) {
    const Eigen::Vector3d to = box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(k)) - closer.from;
    widest = std::max(widest, std::acos(to.normalized().dot(towards)) * 180 / M_PI);
  }
  EXPECT_LT(widest, 25);
  EXPECT_GT(widest, 15);
}

TEST(Viewpoint, ExistsForAnEmptyCloudAndNoCamera) { EXPECT_TRUE(startViewpoint(Cloud(), {}).from.allFinite()); }

TEST(StatusText, SaysWhatIsShown) {
  Playback playback(12, 30);
  playback.setSpeed(0.5);
  playback.play();
  FusionControls controls("fuse_flow", io::MethodOptions());
  controls.toggle(Component::DistanceConsistency);
  FusedFrame frame;
  frame.frame = 7;
  frame.read_ms = 12.34;
  auto cloud = std::make_shared<FusedCloud>();
  cloud->setting = controls.fused();
  cloud->cloud = std::make_shared<Cloud>(85, 1);
  cloud->statistics.total_ms = 40;
  cloud->statistics.preprocess_ms = 1;
  cloud->statistics.generate_ms = 2;
  cloud->statistics.merge_ms = 3;
  cloud->statistics.fuse_ms = 30;
  cloud->statistics.output_ms = 4;
  cloud->quality.emplace();
  cloud->quality->error = 0.0041;
  cloud->quality->multi_view_error = std::numeric_limits<double>::quiet_NaN();
  cloud->quality->pixels = 4;
  cloud->quality->covered_pixels = 3;
  cloud->surface.emplace();
  cloud->surface->points = cloud->surface->surface_points = 50;
  cloud->surface->noise_sum = 50 * 0.0031;
  cloud->surface->violating_points = 1;
  cloud->surface->pixels = 4;
  cloud->surface->covered_pixels = 3;
  frame.clouds[0] = cloud;
  const std::string text = statusText(playback, {2.5, 40}, frame, false);
  for (const char* words :
       {"frame 8 of 12 (000007), playing at 0.500x (15 frames/s), looping",
        "2.5 clouds/s, 40.0 pictures/s, reading 12.3 ms", "1 MF on  2 DC OFF  3 SA on",
        "FUSE-Flow: 85 points, violations off silhouettes 2.0 %,",
        "double surfaces -, noise 3.1 mm, covers 75.0 % within noise; off noisy depth: E_MC 4.1 mm (2+ views -)",
        "total 40.0 ms = prepare 1.0, generate 2.0, merge 3.0, fuse 30.0, output 4.0"})
    EXPECT_NE(text.find(words), std::string::npos) << "'" << words << "' is not in\n" << text;
  EXPECT_NE(text.find("0 poses given"), std::string::npos) << text;
  EXPECT_EQ(text.find("off truth"), std::string::npos) << "nobody said what is true";
  cloud->truth_distance = 0.0025;
  EXPECT_NE(cloudText(*cloud).find("85 points, 2.5 mm off truth, violations off silhouettes 2.0 %"), std::string::npos)
      << cloudText(*cloud);
  cloud->surface->flicker = {10, 0.004};
  EXPECT_NE(cloudText(*cloud).find("noise 3.1 mm, flicker 0.4 mm, covers 75.0 %"), std::string::npos)
      << cloudText(*cloud);
  EXPECT_EQ(text.find("being fused"), std::string::npos);
  playback.pause();
  const std::string standing = statusText(playback, {2.5, 40}, frame, true);
  EXPECT_NE(standing.find("played at 2.5 clouds/s, 40.0 pictures/s"), std::string::npos) << standing;
  EXPECT_EQ(statusText(playback, {}, frame, true).find("clouds/s"), std::string::npos) << "it never played";
  EXPECT_NE(standing.find("being fused"), std::string::npos) << standing;
  frame.damaged = {"camera 'left' is missing: 000007.png: is cut short"};
  EXPECT_NE(statusText(playback, {}, frame, false).find("\n" + frame.damaged[0]), std::string::npos);
  frame.ended = {"camera 'right' ends after 7 of 12 frames"};
  EXPECT_NE(statusText(playback, {}, frame, false).find("\n" + frame.ended[0]), std::string::npos);
  EXPECT_EQ(statusText(Playback(std::nullopt, 30), {}, frame, false).rfind("frame 8 (000007), ", 0), 0u);
}

TEST(StatusText, TheTimesOfWhatIsComparedWithHaveTheirNames) {
  FusionControls controls("voxel_grid", io::MethodOptions());
  FusedCloud cloud;
  cloud.setting = controls.fused();
  cloud.cloud = std::make_shared<Cloud>();
  cloud.statistics.generate_ms = 5;
  cloud.statistics.fuse_ms = 3;
  cloud.statistics.output_ms = 1;
  cloud.statistics.total_ms = 9;
  EXPECT_NE(cloudText(cloud).find("total 9.0 ms = back-projection 5.0, thinning 3.0, output 1.0"), std::string::npos)
      << cloudText(cloud);
}

TEST(StatusText, AHeadingSaysWhatWouldBeTakenForAFault) {
  FusionControls controls("concatenate", io::MethodOptions());
  FusedCloud cloud;
  cloud.setting = controls.fused();
  cloud.cloud = std::make_shared<Cloud>();
  EXPECT_EQ(headingOf(cloud, ColorBy::Confidence, false), "");
  EXPECT_EQ(headingOf(cloud, ColorBy::Confidence, true), "concatenated");
  cloud.attributes.confidence_known = false;
  EXPECT_EQ(headingOf(cloud, ColorBy::Rgb, true), "concatenated");
  EXPECT_EQ(headingOf(cloud, ColorBy::Confidence, true), "concatenated: has no confidence, grey");
  cloud.attributes.views_known = false;
  EXPECT_EQ(headingOf(cloud, ColorBy::Views, false), "counts no cameras, grey");
  cloud.why_empty = "no point passes tau = 1";
  EXPECT_EQ(headingOf(cloud, ColorBy::Views, false), "no point passes tau = 1");
  EXPECT_NE(cloudText(cloud).find("0 points, no point passes tau = 1"), std::string::npos) << cloudText(cloud);
}

TEST(StatusText, SaysHowFarPosesWentTheLargestFirstAndWhichCameraHasMoved) {
  std::vector<Camera> cameras(6);
  RefinedExtrinsics refined;
  for (std::size_t k = 0; k < cameras.size(); ++k) {
    cameras[k].name = "cam" + std::to_string(k);
    refined.corrections.push_back({k, Eigen::Isometry3d::Identity(), 0.001 * static_cast<double>(k), M_PI / 180});
  }
  refined.moved = {{2, Eigen::Isometry3d::Identity(), 0.0512, 2 * M_PI / 180}};
  EXPECT_EQ(refinementText(refined, cameras),
            "\n  cam5 by 5.0 mm, 1.00 deg, cam4 by 4.0 mm, 1.00 deg, cam3 by 3.0 mm, 1.00 deg, "
            "3 others by less\ncamera 'cam2' has moved by 51.2 mm and 2.00 degrees");
  refined.corrections.resize(4);
  EXPECT_NE(refinementText(refined, cameras).find(", 1 other by less\n"), std::string::npos);
}

/** \brief An orthographic view along −z: x and y as they are. */
TEST(DrawnPoint, IsTheOneInFrontOfThoseWithinTheRadius) {
  Eigen::Matrix4f projection = Eigen::Matrix4f::Identity();
  projection(2, 2) = -1;
  Cloud cloud;
  const auto add = [&](float x, float y, float z) {
    cloud.push_back(PointFused());
    cloud[cloud.size() - 1].getVector3fMap() = Eigen::Vector3f(x, y, z);
  };
  add(0.1f, 0, 0.2f);
  add(0.12f, 0, 0.5f);  // nearer to the viewer
  add(0.2f, 0, 0.9f);   // nearer still, but outside of the radius
  add(0.1f, 0, 1.5f);   // in front of the near plane
  add(0, 0.9f, 0);
  const Eigen::Vector2f radius(0.05f, 0.05f);
  EXPECT_EQ(pointDrawnAt(cloud, projection, {0.1f, 0}, radius), 1u);
  EXPECT_EQ(pointDrawnAt(cloud, projection, {0.06f, 0}, radius), 0u);
  EXPECT_EQ(pointDrawnAt(cloud, projection, {-0.5f, 0}, radius), std::nullopt);
  EXPECT_EQ(pointDrawnAt(cloud, projection, {0, 0.7f}, {0.05f, 0.25f}), 4u) << "the radius is an ellipse's";
}

TEST(DrawnPoint, ARectangleHoldsHiddenPointsTooAndNoneThatIsNotDrawn) {
  Eigen::Matrix4f projection = Eigen::Matrix4f::Identity();
  projection(2, 2) = -1;
  Cloud cloud(6, 1);
  const float places[6][3] = {{0.1f, 0.2f, 0},   {0.1f, 0.2f, 0.5f}, {0.31f, 0.2f, 0},
                              {0.1f, -0.01f, 0}, {0.1f, 0.2f, 1.5f}, {0.3f, 0, 0}};
  for (std::size_t k = 0; k < 6; ++k) cloud[k].getVector3fMap() = Eigen::Vector3f(places[k]);
  EXPECT_EQ(pointsDrawnIn(cloud, projection, {0, 0}, {0.3f, 0.4f}), (std::vector<std::size_t>{0, 1, 5}));
}

/** \brief With a perspective, what is behind the viewer would be drawn upside down. */
TEST(DrawnPoint, IsNeverBehindTheViewer) {
  Eigen::Matrix4f projection = Eigen::Matrix4f::Identity();
  projection.row(3) << 0, 0, -1, 0;
  Cloud cloud(1, 1);
  cloud[0].getVector3fMap() = Eigen::Vector3f(0, 0, 2);
  EXPECT_EQ(pointDrawnAt(cloud, projection, {0, 0}, {1, 1}), std::nullopt);
  cloud[0].z = -2;
  EXPECT_EQ(pointDrawnAt(cloud, projection, {0, 0}, {1, 1}), 0u);
}

}  // namespace
}  // namespace viewer_test
