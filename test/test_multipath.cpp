#include "refusal.h"
#include "scenes.h"

#include <fuse_flow/depth_backprojection.h>
#include <fuse_flow/fuse_flow.h>
#include <fuse_flow/impl/host/multipath_correction.hpp>

#include <pcl/point_types.h>

#include <complex>
#include <random>

// Light on detours, and what takes it from the depth of a time-of-flight camera.

namespace {

using namespace fuse_flow;
using namespace scenes;
using refusal::expectThrow;

constexpr double kPi = 3.14159265358979323846;
constexpr float kFrequency = 200e6f, kReflectance = 0.6f;

TEST(Multipath, SineAndAngleAreThoseOfTheLibrary) {
  for (int k = -4000; k <= 4000; ++k) {
    const double turns = 0.001 * k;
    EXPECT_NEAR(sineOfTurns(static_cast<float>(turns)), std::sin(2 * kPi * turns), 1.2e-3) << turns;
    const double x = std::cos(2 * kPi * turns), y = std::sin(2 * kPi * turns);
    const float found = turnsOf(static_cast<float>(3 * y), static_cast<float>(3 * x));
    EXPECT_NEAR(found, std::atan2(y, x) / (2 * kPi), 3e-6) << turns;
  }
  EXPECT_EQ(turnsOf(0, 0), 0.0f);
  EXPECT_FLOAT_EQ(turnsOf(0, -1), 0.5f);
}

TEST(Multipath, ThePeriodIsHalfAWavelength) { EXPECT_NEAR(multipathPeriod(kFrequency), 0.749481, 1e-6); }

/** \brief A camera with one lamp, 240 × 240 pixels, ± 31°. */
Camera lampCamera() {
  Camera camera;
  camera.name = "lamp";
  camera.intrinsics.width = camera.intrinsics.height = 240;
  camera.intrinsics.fx = camera.intrinsics.fy = 200;
  camera.intrinsics.cx = camera.intrinsics.cy = 119.5f;
  camera.multipath = {kFrequency, kReflectance};
  return camera;
}

/** \brief Depth that a surface has on each ray (x, y, 1). */
template <typename DepthOf>
std::vector<float> draw(const Camera& camera, const DepthOf& depth_of) {
  const Intrinsics& K = camera.intrinsics;
  std::vector<float> z;
  for (int v = 0; v < K.height; ++v)
    for (int u = 0; u < K.width; ++u)
      z.push_back(static_cast<float>(depth_of((u - static_cast<double>(K.cx)) / static_cast<double>(K.fx),
                                              (v - static_cast<double>(K.cy)) / static_cast<double>(K.fy))));
  return z;
}

/** \brief Two walls that meet in a right angle at x = 0, z = 2, open towards the camera: z = 2 − |x|. */
std::vector<float> drawCorner(const Camera& camera) {
  return draw(camera, [](double x, double) { return 2 / (1 + std::fabs(x)); });
}

/** \brief What is left of an image of depth. */
std::vector<float> corrected(const Camera& camera, const std::vector<float>& z) {
  DepthView view;
  view.depth32 = {z.data(), camera.intrinsics.width, camera.intrinsics.height};
  host::ViewGeometry geometry;
  geometry.assign(camera);
  host::DepthMap map;
  host::makeDepthMap({}, geometry, view, map);
  std::vector<float> result;
  for (int v = 0; v < map.height(); ++v) result.insert(result.end(), map.row(v), map.row(v) + map.width());
  return result;
}

/** \brief By how much light from the left wall delays a place on the right one, along its ray, metres: an integral over the wall,
 *  square by square, of what a lamp sends that lights what the camera sees. */
double delayInCorner(const Camera& camera, const Eigen::Vector3d& place) {
  const Eigen::Vector3d m = Eigen::Vector3d(1, 0, -1).normalized(), n = Eigen::Vector3d(-1, 0, -1).normalized();
  const double edge = 120 / static_cast<double>(camera.intrinsics.fx), step = 0.01;
  const double period = 299792458.0 / (2 * static_cast<double>(camera.multipath.modulation_frequency));
  const double straight = -n.dot(place) / std::pow(place.norm(), 3);
  std::complex<double> light = straight;
  for (double x = -1 + step / 2; x < 0; x += step)
    for (double y = -2 + step / 2; y < 2; y += step) {
      const Eigen::Vector3d source(x, y, 2 + x);
      if (-x > edge * source.z() || std::fabs(y) > edge * source.z()) continue;
      const Eigen::Vector3d between = place - source;
      const double r = source.norm(), d = between.norm(), area = step * step * std::sqrt(2.0);
      const double lit = -m.dot(source) / (r * r * r);
      const double arrives = static_cast<double>(camera.multipath.reflectance) * lit * area * m.dot(between) *
                             -n.dot(between) / (kPi * d * d * d * d);
      light += std::polar(arrives, kPi * (r + d - place.norm()) / period);
    }
  return period * std::arg(light) / (2 * kPi);
}

TEST(Multipath, WhatIsTakenAwayIsTheDelayOfAllLightThatComesByTheOtherWall) {
  for (const Multipath& multipath :
       {Multipath{kFrequency, 0.6f}, Multipath{kFrequency, 0.3f}, Multipath{60e6f, 0.6f}}) {
    Camera camera = lampCamera();
    camera.multipath = multipath;
    const std::vector<float> z = drawCorner(camera), less = corrected(camera, z);
    for (const auto& [u, v] : {std::pair{140, 120}, std::pair{160, 120}, std::pair{190, 70}, std::pair{220, 160}}) {
      const std::size_t k = static_cast<std::size_t>(240 * v + u);
      const double x = (u - 119.5) / 200, y = (v - 119.5) / 200;
      const Eigen::Vector3d ray(x, y, 1);
      const double expected = delayInCorner(camera, static_cast<double>(z[k]) * ray) / ray.norm();
      EXPECT_NEAR(z[k] - less[k], expected, 0.12 * std::fabs(expected) + 0.0005)
          << u << ", " << v << " at " << multipath.modulation_frequency << " Hz";
      const std::size_t mirrored = static_cast<std::size_t>(240 * v + 239 - u);
      EXPECT_NEAR(z[k] - less[k], z[mirrored] - less[mirrored], 1.5e-3) << "the corner has two sides";
    }
  }
}

TEST(Multipath, DepthThatIsLateInACornerComesOutRight) {
  // Measured late by the integral at each patch, between them linearly: what is left is a tenth, where it was late by centimetres.
  const Camera camera = lampCamera();
  const std::vector<float> z = drawCorner(camera);
  std::vector<double> delays;  // by column, in the middle of the image
  for (int u = 0; u < 240; ++u) {
    const int right = std::max(u, 239 - u);
    const Eigen::Vector3d ray((right - 119.5) / 200, 0, 1);
    delays.push_back(delayInCorner(camera, static_cast<double>(z[static_cast<std::size_t>(right)]) * ray) / ray.norm());
  }
  std::vector<float> late = z;
  for (std::size_t k = 0; k < late.size(); ++k) late[k] += static_cast<float>(delays[k % 240]);
  const std::vector<float> right = corrected(camera, late);
  double before = 0, after = 0;
  for (std::size_t u = 128; u < 200; ++u) {
    const std::size_t k = 240 * 120 + u;
    before += std::fabs(static_cast<double>(late[k] - z[k])) / 72;
    after += std::fabs(static_cast<double>(right[k] - z[k])) / 72;
  }
  EXPECT_GT(before, 0.008);
  EXPECT_LT(after, 0.2 * before);
}

TEST(Multipath, AWallAloneStaysAsItIs) {
  const Camera camera = lampCamera();
  const std::vector<float> z = draw(camera, [](double x, double y) { return 2 / (1 - 0.3 * x + 0.2 * y); });
  const std::vector<float> less = corrected(camera, z);
  for (std::size_t k = 0; k < z.size(); ++k) ASSERT_NEAR(less[k], z[k], 2e-5f) << k;
}

TEST(Multipath, WithoutAFrequencyNothingChanges) {
  Camera camera = lampCamera();
  camera.multipath = {};
  const std::vector<float> z = drawCorner(camera);
  EXPECT_EQ(corrected(camera, z), z);
}

TEST(Multipath, HolesStayHolesAndSendNothing) {
  const Camera camera = lampCamera();
  std::vector<float> z = drawCorner(camera);
  for (int v = 0; v < 240; ++v)
    for (int u = 0; u < 120; ++u) z[static_cast<std::size_t>(240 * v + u)] = 0;  // the left wall is black
  const std::vector<float> less = corrected(camera, z);
  for (std::size_t k = 0; k < z.size(); ++k) ASSERT_NEAR(less[k], z[k], z[k] > 0 ? 2e-5f : 0.0f) << k;
}

TEST(Multipath, NoiseInImagesOfAnySizeGivesFiniteDepth) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> depth(0.2f, 4.0f);
  for (const auto& [width, height] :
       {std::pair{1, 1}, std::pair{7, 3}, std::pair{8, 8}, std::pair{33, 65}, std::pair{100, 31}}) {
    Camera camera = lampCamera();
    camera.intrinsics.width = width;
    camera.intrinsics.height = height;
    std::vector<float> z(static_cast<std::size_t>(width * height));
    for (float& value : z) value = random() % 5 == 0 ? 0.0f : depth(random);
    const std::vector<float> less = corrected(camera, z);
    for (std::size_t k = 0; k < z.size(); ++k) {
      ASSERT_TRUE(std::isfinite(less[k]) && less[k] >= 0) << width << "x" << height;
      ASSERT_EQ(less[k] > 0, z[k] > 0);
    }
  }
}

TEST(Multipath, SumsAreTheSameBitsInVectorsAndOneByOne) {
  const Camera camera = lampCamera();
  const std::vector<float> z = drawCorner(camera);
  const std::vector<float> in_vectors = corrected(camera, z);
  // The same by hand, from the maths alone.
  struct Map {
    const std::vector<float>& z;
    const Intrinsics& K;
    float depth(int u, int v) const { return z[static_cast<std::size_t>(K.width * v + u)]; }
    Ray ray(int u, int v) const {
      return {(static_cast<float>(u) - K.cx) / K.fx, (static_cast<float>(v) - K.cy) / K.fy};
    }
  } const map{z, camera.intrinsics};
  constexpr int tiles = 8, patches = 4 * tiles;
  std::vector<SurfacePatch> all, merged;
  for (int tile = 0; tile < tiles * tiles; ++tile) {
    for (int k = 0; k < kTilePatches; ++k)
      all.push_back(makeSurfacePatch(map, camera.intrinsics, tile % tiles * 32 + k % 4 * 8,
                                     tile / tiles * 32 + k / 4 * 8, kReflectance));
    merged.push_back(mergeSurfacePatches(&all[static_cast<std::size_t>(tile) * kTilePatches]));
  }
  const float period = multipathPeriod(kFrequency);
  std::vector<LatePatch> late(static_cast<std::size_t>(patches * patches));
  for (int k = 0; k < patches * patches; ++k) {
    const SurfacePatch& patch = all[static_cast<std::size_t>(k)];
    if (!(patch.power > 0)) continue;
    const int tile = k / kTilePatches, u = tile % tiles * 4 + k % 4, v = tile / tiles * 4 + k % kTilePatches / 4;
    DetourLight lanes[kDetourLanes];
    for (std::uint32_t lane = 0; lane < kDetourLanes; ++lane)
      lanes[lane] = sumDetoursOfLane(DetourReceiver(patch, period), merged.data(), all.data(), tiles * tiles, lane);
    const DetourLight light = sumLanes(lanes);
    late[static_cast<std::size_t>(v * patches + u)] = LatePatch(patch, detourDepth(light, period, patch));
  }
  for (int v = 0; v < 240; ++v)
    for (int u = 0; u < 240; ++u) {
      const PatchPlace column(u, patches), row(v, patches);
      const LatePatch* first = &late[static_cast<std::size_t>(row.first * patches + column.first)];
      const std::size_t k = static_cast<std::size_t>(240 * v + u);
      ASSERT_EQ(in_vectors[k], withoutDetours(first[0], first[1], first[patches], first[patches + 1], column.share,
                                              row.share, map.ray(u, v), z[k]))
          << u << ", " << v;
    }
}

TEST(Multipath, FusionAndBackprojectionCorrectAlike) {
  // One camera, no smoothing, a point a pixel: what FuseFlow fuses is what DepthBackprojection gives.
  const Camera camera = lampCamera();
  const std::vector<float> z = drawCorner(camera), less = corrected(camera, z);
  DepthView view;
  view.depth32 = {z.data(), 240, 240};
  DepthBackprojection<pcl::PointXYZ> backprojection;
  backprojection.setCamera(camera);
  backprojection.setView(view);
  pcl::PointCloud<pcl::PointXYZ> cloud;
  backprojection.filter(cloud);
  ASSERT_EQ(cloud.size(), less.size());
  for (std::size_t k = 0; k < less.size(); ++k) ASSERT_NEAR(cloud[k].z, less[k], 1e-6f);
  FuseFlow<PointFused> fusion;
  FuseFlowParameters parameters;
  parameters.use_spatial_hash = false;
  parameters.use_measurement_confidence = false;
  parameters.smoothing.passes = 0;
  parameters.max_noise = 0;
  fusion.setParameters(parameters);
  pcl::PointCloud<PointFused> fused;
  fusion.fuse({{camera}, {view}}, fused);
  ASSERT_EQ(fused.size(), less.size());
  for (std::size_t k = 0; k < less.size(); ++k) ASSERT_NEAR(fused[k].z, less[k], 1e-5f);
}

TEST(Multipath, ACameraThatHasNoneIsLeftAlone) {
  // Two cameras with the same image: only one is a time-of-flight camera.
  std::vector<Camera> cameras(2, lampCamera());
  cameras[0].multipath = {};
  const std::vector<float> z = drawCorner(cameras[0]), less = corrected(cameras[1], z);
  ASSERT_NE(z, less);
  DepthView view;
  view.depth32 = {z.data(), 240, 240};
  FuseFlow<PointFused> fusion;
  FuseFlowParameters parameters;
  parameters.use_spatial_hash = parameters.use_measurement_confidence = parameters.use_distance_consistency = false;
  parameters.smoothing.passes = 0;
  parameters.max_noise = 0;
  fusion.setParameters(parameters);
  pcl::PointCloud<PointFused> fused;
  fusion.fuse({cameras, {view, view}}, fused);
  ASSERT_EQ(fused.size(), 2 * z.size());
  for (std::size_t k = 0; k < z.size(); ++k) {
    ASSERT_NEAR(fused[k].z, z[k], 1e-5f);
    ASSERT_NEAR(fused[z.size() + k].z, less[k], 1e-5f);
  }
}

TEST(Multipath, WhatIsOutOfRangeIsRefusedByName) {
  Camera camera = lampCamera();
  for (const float wrong : {-1.0f, 1e5f, 2e9f, NAN, INFINITY}) {
    camera.multipath = {wrong, 0.6f};
    expectThrow<pcl::BadArgumentException>([&] { checkCamera(camera); },
                                           {"'lamp'", "modulation_frequency", "1e6 to 1e9"});
  }
  for (const float wrong : {0.0f, -0.1f, 1.1f, NAN}) {
    camera.multipath = {kFrequency, wrong};
    expectThrow<pcl::BadArgumentException>([&] { checkCamera(camera); }, {"'lamp'", "reflectance", "(0, 1]"});
  }
  camera.multipath = {0, 1};
  checkCamera(camera);
}

}  // namespace
