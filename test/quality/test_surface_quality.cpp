#include "../refusal.h"
#include "../scenes.h"

#include <fuse_flow/impl/quality/point_index.hpp>
#include <fuse_flow/quality/reprojection_quality.h>
#include <fuse_flow/quality/surface_quality.h>

#include <pcl/point_types.h>

#include <cmath>
#include <random>

namespace {

using fuse_flow::SurfaceQuality;
using fuse_flow::surfaceQuality;
using fuse_flow::SurfaceQualityParameters;
using fuse_flow::TemporalFlicker;
using fuse_flow::temporalFlicker;
using scenes::Scene;
using Points = pcl::PointCloud<pcl::PointXYZ>;

constexpr float kSpacing = 0.005f;

/** \brief A camera at the origin that looks along z at a wall 1 m away. */
Scene wallAt(float distance = 1.0f, int width = 96, int height = 72) {
  return scenes::makeFlatScene(scenes::sameCameras(1, width, height, 90), {distance});
}

/** \brief Points of the plane z = height(i, j), on a grid of 5 mm around the z axis. */
template <typename Height>
Points sheet(const Height& height, int half = 40) {
  Points cloud;
  for (int j = -half; j <= half; ++j)
    for (int i = -half; i <= half; ++i)
      cloud.push_back({kSpacing * static_cast<float>(i), kSpacing * static_cast<float>(j), height(i, j)});
  return cloud;
}
Points flatSheet(float z, int half = 40) {
  return sheet([z](int, int) { return z; }, half);
}

TEST(SurfaceQuality, APlaneHasNoNoiseHoweverItLies) {
  const Points tilted =
      sheet([](int i, int j) { return 1 + 0.002f * static_cast<float>(i) - 0.001f * static_cast<float>(j); });
  const SurfaceQuality quality = surfaceQuality(tilted, wallAt().rig);
  EXPECT_EQ(quality.points, 81u * 81u);
  EXPECT_EQ(quality.surface_points, quality.points);
  EXPECT_LT(quality.noise(), 1e-6);
  EXPECT_EQ(quality.doubleSurfaces(), 0);
}

TEST(SurfaceQuality, NoiseIsTheDeviationFromTheLocalPlane) {
  // A chessboard of 2 mm before and behind the plane: the plane stays, and all are 2 mm off it.
  const Points rough = sheet([](int i, int j) { return (i + j) % 2 == 0 ? 1.002f : 0.998f; });
  EXPECT_NEAR(surfaceQuality(rough, wallAt().rig).noise(), 0.002, 0.0001);
  // Waves much longer than the neighbourhood are shape.
  const Points wavy = sheet([](int i, int) { return 1 + 0.02f * std::sin(0.01f * static_cast<float>(i)); });
  EXPECT_LT(surfaceQuality(wavy, wallAt().rig).noise(), 0.0002);
}

TEST(SurfaceQuality, PointsAloneHaveNoSurface) {
  Points cloud;
  for (int k = 0; k < 10; ++k) cloud.push_back({0.1f * static_cast<float>(k), 0, 1});
  const SurfaceQuality quality = surfaceQuality(cloud, wallAt().rig);
  EXPECT_EQ(quality.sampled_points, 10u);
  EXPECT_EQ(quality.surface_points, 0u);
  EXPECT_TRUE(std::isnan(quality.noise()));
  EXPECT_TRUE(std::isnan(quality.doubleSurfaces()));
  EXPECT_TRUE(std::isnan(surfaceQuality(Points(), wallAt().rig).violationShare()));
}

TEST(SurfaceQuality, TwoSheetsOfOneSurfaceAreDoubleIfTheyAreFiveToFiftyMillimetresApart) {
  const auto twoSheets = [](float apart) {
    Points cloud = flatSheet(1.0f);
    cloud += flatSheet(1.0f + apart);
    return surfaceQuality(cloud, wallAt(1.0f + 0.5f * apart).rig).doubleSurfaces();
  };
  EXPECT_EQ(twoSheets(0.003f), 0);
  EXPECT_EQ(twoSheets(0.006f), 1);
  EXPECT_GT(twoSheets(0.020f), 0.85) << "within 30 mm of the sheets' rims two look like one across";
  EXPECT_EQ(twoSheets(0.048f), 1);
  EXPECT_EQ(twoSheets(0.060f), 0);
}

TEST(SurfaceQuality, NoiseIsNoDoubleSurface) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> even(-0.02f, 0.02f);
  std::normal_distribution<float> normal(0, 0.01f);
  EXPECT_LT(surfaceQuality(sheet([&](int, int) { return 1 + even(random); }), wallAt().rig).doubleSurfaces(), 0.05);
  EXPECT_LT(surfaceQuality(sheet([&](int, int) { return 1 + normal(random); }), wallAt().rig).doubleSurfaces(), 0.02);
}

/** \brief A board of 30 mm, one camera before it and one behind it. */
TEST(SurfaceQuality, TheBackOfABoardIsNoDoubleSurface) {
  std::vector<fuse_flow::Camera> cameras = {scenes::lookAt({0, 0, 0}, {0, 0, 1}),
                                            scenes::lookAt({0, 0, 2.03}, {0, 0, 1})};
  Points cloud = flatSheet(1.0f);
  cloud += flatSheet(1.03f);
  EXPECT_EQ(surfaceQuality(cloud, scenes::makeFlatScene(cameras, {1, 1}).rig).doubleSurfaces(), 0);
  cameras[1] = cameras[0];
  EXPECT_EQ(surfaceQuality(cloud, scenes::makeFlatScene(cameras, {1, 1.03f}).rig).doubleSurfaces(), 1)
      << "seen from one side it would be";
}

/** \brief The left half of the image is an object at 1 m, the right a wall at 2 m. */
TEST(SurfaceQuality, BesideASilhouetteNothingViolatesFreeSpace) {
  Scene scene = wallAt(2.0f);
  for (int v = 0; v < 72; ++v)
    for (int u = 0; u < 48; ++u) scene.depth[0].at(u, v) = 1.0f;
  const auto at = [](float u, float z) { return pcl::PointXYZ((u - 47.5f) / 90 * z, 0, z); };
  Points cloud;
  cloud.push_back(at(49, 1.0f));  // the object, its camera's pose a pixel off
  cloud.push_back(at(60, 1.0f));  // far from the object: floats
  cloud.push_back(at(20, 0.5f));  // before the object: floats
  cloud.push_back(at(49, 0.5f));  // before both: floats
  cloud.push_back(at(60, 2.0f));
  const SurfaceQuality quality = surfaceQuality(cloud, scene.rig);
  EXPECT_EQ(quality.violating_points, 3u);
  EXPECT_EQ(reprojectionQuality(cloud, scene.rig).violating_points, 4u);
  SurfaceQualityParameters exact;
  exact.silhouette = 0;
  EXPECT_EQ(surfaceQuality(cloud, scene.rig, exact).violating_points, 4u);
}

TEST(SurfaceQuality, CoverageReachesAsFarAsTheSensorsNoise) {
  Scene scene = wallAt();
  const Points shifted = flatSheet(1.025f, 120);
  SurfaceQualityParameters parameters;
  EXPECT_EQ(surfaceQuality(shifted, scene.rig, parameters).coverage(), 0);
  // The images have no noise: the least scale is 0.25 of what the parameters say, and three times 10 mm reach.
  parameters.noise.floor = 0.04f;
  parameters.noise.quadratic = 0;
  EXPECT_EQ(surfaceQuality(shifted, scene.rig, parameters).coverage(), 1);
  parameters.max_coverage_radius = 0.02f;
  EXPECT_EQ(surfaceQuality(shifted, scene.rig, parameters).coverage(), 0);
  // The same where the camera itself says so; and an exact camera does not follow what the parameters say of others.
  scene.rig.cameras[0].noise = fuse_flow::NoiseModel{0.04f, 0, 0};
  EXPECT_EQ(surfaceQuality(shifted, scene.rig, {}).coverage(), 1);
  parameters.max_coverage_radius = SurfaceQualityParameters().max_coverage_radius;
  scene.rig.cameras[0].noise = fuse_flow::NoiseModel{0.001f, 0, 0};
  EXPECT_EQ(surfaceQuality(shifted, scene.rig, parameters).coverage(), 0);
}

TEST(SurfaceQuality, DoesNotDependOnWhereTheOriginIs) {
  Scene scene = scenes::makeScene(scenes::cameraRow(3), scenes::ballAndWall());
  scenes::addNoise(scene, 0.004f);
  Points cloud;
  for (const auto& p : scenes::fuse(scene.rig)) cloud.push_back({p.x, p.y, p.z});
  const SurfaceQuality here = surfaceQuality(cloud, scene.rig);
  const fuse_flow::ReprojectionQuality measured_here = reprojectionQuality(cloud, scene.rig);
  for (const double metres : {12e3, 48e3}) {
    fuse_flow::RigFrame rig = scene.rig;
    for (fuse_flow::Camera& camera : rig.cameras) camera.T_world_camera.translation().x() += metres;
    Points moved;
    for (const auto& p : cloud) moved.push_back({static_cast<float>(static_cast<double>(p.x) + metres), p.y, p.z});
    const SurfaceQuality there = surfaceQuality(moved, rig);
    EXPECT_NEAR(there.coverage(), here.coverage(), 0.01) << metres;
    EXPECT_NEAR(there.violationShare(), here.violationShare(), 0.01) << metres;
    EXPECT_NEAR(there.noise(), here.noise(), 0.001) << "the cloud itself is rounded to 4 mm";
    const fuse_flow::ReprojectionQuality measured = reprojectionQuality(moved, rig);
    EXPECT_NEAR(measured.coverage(), measured_here.coverage(), 0.01) << metres;
    EXPECT_NEAR(measured.error, measured_here.error, 0.001) << metres;
  }
}

/** \brief More cells from the origin than 21 bits count, 200 m away. */
TEST(SurfaceQuality, ASmallRadiusFindsWhatIsFarAway) {
  Scene scene = wallAt();
  Points cloud;
  for (fuse_flow::Camera& camera : scene.rig.cameras) camera.T_world_camera.translation().z() += 200;
  for (int v = 0; v < 72; ++v)
    for (int u = 0; u < 96; ++u)
      cloud.push_back({(static_cast<float>(u) - 47.5f) / 90, (static_cast<float>(v) - 35.5f) / 90, 201.0f});
  fuse_flow::ReprojectionQualityParameters fine;
  fine.coverage_radius = 0.0001f;
  EXPECT_EQ(reprojectionQuality(cloud, scene.rig, fine).coverage(), 1);
  cloud.push_back({3e38f, -3e38f, 3e38f});  // as far as a float goes
  EXPECT_EQ(reprojectionQuality(cloud, scene.rig, fine).coverage(), 1);
}

TEST(SurfaceQuality, FlickerIsTheJumpOfWhatStandsStill) {
  const Scene scene = wallAt();
  EXPECT_NEAR(temporalFlicker(flatSheet(1.0f), scene.rig, flatSheet(1.004f), scene.rig).mean(), 0.004, 1e-6);
  EXPECT_NEAR(temporalFlicker(flatSheet(1.0f), scene.rig, flatSheet(1.0f), scene.rig).mean(), 0, 1e-9);
  // Where the other cloud has nothing the point is gone.
  EXPECT_NEAR(temporalFlicker(flatSheet(1.0f), scene.rig, Points(), scene.rig).mean(), 0.03, 1e-6);
  EXPECT_TRUE(std::isnan(temporalFlicker(Points(), scene.rig, Points(), scene.rig).mean()));
}

TEST(SurfaceQuality, WhatMovesDoesNotFlicker) {
  Scene before = wallAt(), after = wallAt();
  for (int v = 0; v < 72; ++v)
    for (int u = 0; u < 48; ++u) after.depth[0].at(u, v) = 1.02f;  // the left half comes 20 mm away
  Points first = flatSheet(1.0f), second;
  for (const auto& p : first) second.push_back({p.x, p.y, p.x < 0 ? 1.02f : 1.0f});
  const TemporalFlicker flicker = temporalFlicker(first, before.rig, second, after.rig);
  EXPECT_GT(flicker.points, 0.4 * static_cast<double>(first.size() + second.size()));
  EXPECT_LT(flicker.points, 0.6 * static_cast<double>(first.size() + second.size()));
  EXPECT_LT(flicker.mean(), 0.0005);
  // Noise of the depth is no motion: the clouds are as before, and the whole surface counts.
  scenes::addNoise(before, 0.01f);
  after = wallAt();
  EXPECT_NEAR(static_cast<double>(temporalFlicker(first, before.rig, first, after.rig).points),
              static_cast<double>(2 * first.size()), 0.1 * static_cast<double>(first.size()));
}

TEST(SurfaceQuality, FramesAddUp) {
  const Scene scene = wallAt();
  SurfaceQuality sum;
  const SurfaceQuality smooth = surfaceQuality(flatSheet(1.0f), scene.rig),
                       rough = surfaceQuality(sheet([](int i, int j) { return (i + j) % 2 == 0 ? 1.002f : 0.998f; }),
                                              scene.rig);
  EXPECT_TRUE(std::isnan(sum.noise()));
  sum += smooth;
  sum += rough;
  EXPECT_NEAR(sum.noise(), 0.5 * (smooth.noise() + rough.noise()), 1e-9);
  EXPECT_EQ(sum.pixels, 2 * smooth.pixels);
}

TEST(SurfaceQuality, DoesNotDependOnTheNumberOfThreads) {
  Scene scene = scenes::makeScene(scenes::cameraRow(3), scenes::ballAndWall());
  scenes::addNoise(scene, 0.005f);
  const scenes::Cloud cloud = scenes::fuse(scene.rig);
  const SurfaceQuality one = surfaceQuality(cloud, scene.rig, {}, 1), three = surfaceQuality(cloud, scene.rig, {}, 3);
  EXPECT_EQ(one.noise_sum, three.noise_sum);
  EXPECT_EQ(one.double_points, three.double_points);
  EXPECT_EQ(one.violating_points, three.violating_points);
  EXPECT_EQ(one.covered_pixels, three.covered_pixels);
  EXPECT_EQ(temporalFlicker(cloud, scene.rig, cloud, scene.rig, {}, 1).sum,
            temporalFlicker(cloud, scene.rig, cloud, scene.rig, {}, 3).sum);
}

TEST(SurfaceQuality, ParametersOutOfRangeAreRefusedByName) {
  const Scene scene = wallAt();
  const auto refused = [&](float SurfaceQualityParameters::*member, float value, const char* message) {
    SurfaceQualityParameters parameters;
    parameters.*member = value;
    refusal::expectThrow([&] { surfaceQuality(flatSheet(1), scene.rig, parameters); }, {"surfaceQuality", message});
  };
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  refused(&SurfaceQualityParameters::neighborhood, 0, "neighborhood is 0");
  refused(&SurfaceQualityParameters::neighborhood, 30, "neighborhood is 30");  // millimetres meant
  refused(&SurfaceQualityParameters::visibility, nan, "visibility is nan");
  refused(&SurfaceQualityParameters::max_separation, 0.004f, "max_separation is 0.004, must exceed min_separation");
  refused(&SurfaceQualityParameters::coverage_radius, 0.07f, "max_coverage_radius is 0.06, must not be below");
  refused(&SurfaceQualityParameters::coverage_deviations, -1, "coverage_deviations is -1");
  refused(&SurfaceQualityParameters::max_motion, -1, "max_motion is -1");
  refused(&SurfaceQualityParameters::max_range, 0.05f, "max_range is 0.05, must exceed min_range");
  SurfaceQualityParameters parameters;
  parameters.silhouette = 9;
  refusal::expectThrow([&] { surfaceQuality(flatSheet(1), scene.rig, parameters); }, {"silhouette is 9"});
  const Scene two = scenes::makeFlatScene(scenes::sameCameras(2, 20, 15, 40), {1.0f, 1.0f});
  refusal::expectThrow([&] { temporalFlicker(flatSheet(1), scene.rig, flatSheet(1), two.rig); },
                       {"temporalFlicker", "1 and 2 cameras"});
}

TEST(PointIndex, FindsTheNearestPointWithinARadiusWhateverItsCells) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> in_cube(-0.1f, 0.1f);
  std::vector<fuse_flow::Vec3> points;
  for (int k = 0; k < 400; ++k) points.push_back({in_cube(random), in_cube(random), in_cube(random)});
  points.insert(points.end(), points.begin(), points.begin() + 200);  // each of these twice: the first is named
  for (const float cell : {0.003f, 0.02f, 0.5f}) {
    const fuse_flow::detail::PointIndex index(points, cell);
    int found = 0, nowhere = 0;
    for (int k = 0; k < 300; ++k) {
      const fuse_flow::Vec3 place =
          k % 3 == 0 ? points[static_cast<std::size_t>(k)] : fuse_flow::Vec3{in_cube(random), in_cube(random), 0};
      const float radius = k % 2 == 0 ? 0.01f : 0.03f;
      std::size_t nearest = points.size();
      float least = radius * radius;
      for (std::size_t p = 0; p < points.size(); ++p) {
        const float squared = squaredNorm(points[p] - place);
        if (squared < least || (squared <= least && nearest == points.size())) least = squared, nearest = p;
      }
      const auto neighbor = index.nearest(place, radius);
      ASSERT_EQ(neighbor.has_value(), nearest < points.size());
      if (!neighbor) {
        ++nowhere;
        continue;
      }
      ++found;
      EXPECT_EQ(neighbor->number, nearest);
      EXPECT_EQ(neighbor->squared_distance, least);
    }
    EXPECT_GT(found, 100);
    EXPECT_GT(nowhere, 20);
  }
  EXPECT_FALSE(fuse_flow::detail::PointIndex({}, 0.01f).nearest({0, 0, 0}, 1).has_value());
}

}  // namespace
