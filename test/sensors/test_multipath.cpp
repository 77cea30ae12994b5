#include "../refusal.h"
#include "../scenes.h"

#include "simulation/simulator.h"

#include <fuse_flow/calibration/extrinsic_estimation.h>
#include <fuse_flow/filters/depth_backprojection.h>
#include <fuse_flow/fuse_flow.h>
#include <fuse_flow/impl/calibration/alignment_view.hpp>
#include <fuse_flow/impl/sensors/multipath_correction.hpp>
#include <fuse_flow/math/calibration/correspondence.h>
#include <fuse_flow/quality/reprojection_quality.h>

#include <pcl/point_types.h>

#include <complex>
#include <random>

// Multipath interference, and what takes it from the depth of a time-of-flight camera.

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

TEST(Multipath, ASquareSendsWhatAllItsPlacesSend) {
  // A square of 1 m on the floor, beside a wall; places on the wall, from the middle of the nearest square of it on upwards.
  for (const auto& [height, tolerance] :
       {std::pair{0.5, 0.04}, std::pair{1.0, 0.15}, std::pair{2.0, 0.08}, std::pair{4.0, 0.03}}) {
    constexpr int parts = 200;
    double expected = 0;  // mean of cos α_x cos α_y / d²
    for (int i = 0; i < parts; ++i)
      for (int j = 0; j < parts; ++j) {
        const double x = (i + 0.5) / parts, y = (j + 0.5) / parts - 0.5, squared = x * x + y * y + height * height;
        expected += x * height / (squared * squared) / (parts * parts);
      }
    SurfacePatch place;
    place.p = {0, 0, static_cast<float>(height)};
    place.n = {1, 0, 0};
    place.distance = 10;  // any: it decides the phase alone
    IndirectReceiver receiver(place, 1e6f);
    receiver.scale = 1;
    const IndirectLight light = receiver.from({0.5f, 0, 0}, {0, 0, 1}, 1.0f, 1.0f, 10.0f);
    EXPECT_NEAR(std::hypot(light.in_phase, light.behind), expected, tolerance * expected) << height;
  }
}

/** \brief A camera with one lamp, ± 31°, of so many pixels each way. */
Camera lampCamera(int side = 240) {
  Camera camera;
  camera.name = "lamp";
  camera.intrinsics.width = camera.intrinsics.height = side;
  camera.intrinsics.fx = camera.intrinsics.fy = static_cast<float>(side) / 1.2f;
  camera.intrinsics.cx = camera.intrinsics.cy = 0.5f * static_cast<float>(side - 1);
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
 *  square by square, of what a lamp sends that lights what the camera sees; \param step sides of the squares, metres. */
double delayInCorner(const Camera& camera, const Eigen::Vector3d& place, double step = 0.01) {
  const Eigen::Vector3d m = Eigen::Vector3d(1, 0, -1).normalized(), n = Eigen::Vector3d(-1, 0, -1).normalized();
  const double edge = 0.6;
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
    Camera camera = lampCamera(480);  // its patches are small
    camera.multipath = multipath;
    const std::vector<float> z = drawCorner(camera), less = corrected(camera, z);
    for (const auto& [u, v] : {std::pair{260, 240}, std::pair{280, 240}, std::pair{320, 240}, std::pair{380, 140},
                               std::pair{440, 320}, std::pair{470, 20}}) {
      const std::size_t k = static_cast<std::size_t>(480 * v + u);
      const Eigen::Vector3d ray((u - 239.5) / 400, (v - 239.5) / 400, 1);
      const double expected = delayInCorner(camera, static_cast<double>(z[k]) * ray) / ray.norm();
      EXPECT_NEAR(z[k] - less[k], expected, 0.03 * std::fabs(expected) + 0.0003)
          << u << ", " << v << " at " << multipath.modulation_frequency << " Hz";
      const std::size_t mirrored = static_cast<std::size_t>(480 * v + 479 - u);
      EXPECT_NEAR(z[mirrored] - less[mirrored], expected, 0.03 * std::fabs(expected) + 0.0003)
          << "on the other wall of " << u << ", " << v;
    }
  }
}

/** \brief A corner as a sensor measures it in the middle row of the image: late by the integral. All rows are alike. */
std::vector<float> drawLateCorner(const Camera& camera) {
  std::vector<float> z = drawCorner(camera);
  const int side = camera.intrinsics.width;
  for (int u = 0; u < side / 2; ++u) {
    const double x = (static_cast<double>(camera.intrinsics.cx) - u) / static_cast<double>(camera.intrinsics.fx);
    const Eigen::Vector3d ray(x, 0, 1);
    const float delay = static_cast<float>(delayInCorner(camera, 2 / (1 + x) * ray, 0.02) / ray.norm());
    for (int v = 0; v < side; ++v)
      for (const int column : {u, side - 1 - u}) z[static_cast<std::size_t>(side * v + column)] += delay;
  }
  return z;
}

TEST(Multipath, DepthThatIsLateInACornerComesOutRight) {
  const Camera camera = lampCamera();
  const std::vector<float> z = drawCorner(camera), late = drawLateCorner(camera), right = corrected(camera, late);
  double before = 0, after = 0;
  for (std::size_t u = 128; u < 200; ++u) {
    const std::size_t k = 240 * 120 + u;
    before += std::fabs(static_cast<double>(late[k] - z[k])) / 72;
    after += std::fabs(static_cast<double>(right[k] - z[k])) / 72;
  }
  EXPECT_GT(before, 0.008);
  EXPECT_LT(after, 0.2 * before) << "the surfaces that it goes by are bent themselves";
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

TEST(Multipath, ABlockWithHolesSendsAsMuchLessAsItMeasured) {
  // Every other pixel of the left wall: half the light comes from there, as from a wall that reflects half.
  Camera camera = lampCamera();
  std::vector<float> z = drawCorner(camera);
  for (int v = 0; v < 240; ++v)
    for (int u = v % 2; u < 120; u += 2) z[static_cast<std::size_t>(240 * v + u)] = 0;
  const std::vector<float> less = corrected(camera, z);
  camera.multipath.reflectance = 0.5f * kReflectance;
  const std::vector<float> whole = drawCorner(camera), half = corrected(camera, whole);
  double taken = 0;
  for (int u = 125; u < 230; ++u) {
    const std::size_t k = static_cast<std::size_t>(240 * 120 + u);
    const double expected = static_cast<double>(whole[k] - half[k]);
    EXPECT_NEAR(z[k] - less[k], expected, 0.1 * std::fabs(expected) + 0.0002) << u;
    taken += std::fabs(expected) / 105;
  }
  EXPECT_GT(taken, 0.002);
}

TEST(Multipath, APixelGoesByItsOwnSurfaceAlone) {
  // A panel that faces the camera stands before the right wall: no light comes to it, and centimetres' worth to the wall around it.
  const Camera camera = lampCamera();
  std::vector<float> z = drawCorner(camera);
  const auto onPanel = [](int u, int v) { return u >= 125 && u < 170 && v >= 101 && v < 142; };
  for (int v = 0; v < 240; ++v)
    for (int u = 0; u < 240; ++u)
      if (onPanel(u, v)) z[static_cast<std::size_t>(240 * v + u)] = 1;
  const std::vector<float> less = corrected(camera, z);
  for (int v = 101; v < 142; ++v)
    for (int u = 125; u < 170; ++u)
      ASSERT_NEAR(less[static_cast<std::size_t>(240 * v + u)], 1, 1e-4f) << u << ", " << v;
  const std::size_t above = 240 * 98 + 135;
  EXPECT_GT(z[above] - less[above], 0.01f) << "the wall just above the panel is late";
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
    IndirectLight lanes[kIndirectLanes];
    for (std::uint32_t lane = 0; lane < kIndirectLanes; ++lane)
      lanes[lane] = sumIndirectOfLane(IndirectReceiver(patch, period), merged.data(), all.data(), tiles * tiles, lane);
    const IndirectLight light = sumLanes(lanes);
    late[static_cast<std::size_t>(v * patches + u)] = LatePatch(patch, multipathBias(light, period, patch));
  }
  for (int v = 0; v < 240; ++v)
    for (int u = 0; u < 240; ++u) {
      const PatchPlace column(u, patches), row(v, patches);
      const LatePatch* first = &late[static_cast<std::size_t>(row.first * patches + column.first)];
      const std::size_t k = static_cast<std::size_t>(240 * v + u);
      ASSERT_EQ(in_vectors[k], withoutMultipath(first[0], first[1], first[patches], first[patches + 1], column.share,
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

TEST(Multipath, AFrequencyThatChangesFromFrameToFrameCounts) {
  Camera camera = lampCamera();
  const std::vector<float> z = drawCorner(camera);
  DepthView view;
  view.depth32 = {z.data(), 240, 240};
  FuseFlow<PointFused> fusion;
  pcl::PointCloud<PointFused> before, after, again;
  fusion.fuse({{camera}, {view}}, before);
  camera.multipath.reflectance = 0.2f;
  fusion.fuse({{camera}, {view}}, after);
  camera.multipath.reflectance = kReflectance;
  fusion.fuse({{camera}, {view}}, again);
  EXPECT_NE(bytes(before), bytes(after));
  EXPECT_EQ(bytes(before), bytes(again));
}

TEST(Multipath, ItIsTakenFromDepthThatHasBeenPutRightOtherwise) {
  const Camera right = lampCamera();
  Camera bent = right;  // measures all depth a fiftieth too short
  bent.depth_correction = {2, 2, std::vector<float>(4, 0.02f), std::vector<float>(4, 0.0f)};
  const std::vector<float> z = drawCorner(right);
  std::vector<float> short_z = z;
  for (float& value : short_z) value /= 1.02f;
  const std::vector<float> expected = corrected(right, z), found = corrected(bent, short_z);
  for (std::size_t k = 0; k < z.size(); ++k) ASSERT_NEAR(found[k], expected[k], 2e-5f) << k;
}

TEST(Multipath, PosesAndTheMeasureOfAgreementSeeTheSameDepth) {
  // Two cameras look into a corner, a third of a metre apart. To give late depth and a frequency is to give right depth.
  std::vector<Camera> cameras(2, lampCamera(160)), plain = cameras;
  cameras[1].T_world_camera.translation() << 0.3, 0.05, 0.1;
  for (std::size_t i = 0; i < 2; ++i) {
    plain[i] = cameras[i];
    plain[i].multipath = {};
  }
  const std::vector<float> late = drawLateCorner(cameras[0]), right = corrected(cameras[0], late);
  DepthView late_view, right_view;
  late_view.depth32 = {late.data(), 160, 160};
  right_view.depth32 = {right.data(), 160, 160};
  const RigFrame with{cameras, {late_view, late_view}}, without{plain, {right_view, right_view}};
  pcl::PointCloud<PointFused> cloud;
  FuseFlow<PointFused>().fuse(without, cloud);
  ASSERT_GT(cloud.size(), 100u);
  EXPECT_EQ(reprojectionQuality(cloud, with).error, reprojectionQuality(cloud, without).error);
  RigFrame raw = with;
  raw.cameras = plain;
  EXPECT_NE(reprojectionQuality(cloud, raw).error, reprojectionQuality(cloud, without).error);
  const auto residual = [](const RigFrame& frame) {
    ExtrinsicEstimation<PointFused> estimation;
    ExtrinsicParameters p;
    p.residual_multipath = 0;
    estimation.setParameters(p);
    estimation.addFrame(frame);
    return estimation.estimate().residual;
  };
  EXPECT_EQ(residual(with), residual(without));
  EXPECT_NE(residual(raw), residual(without));
}

TEST(Multipath, WhatNoViewTellsOfMakesFarDepthUncertain) {
  const Multipath multipath{kFrequency, kReflectance};
  // 7 % of the light at one metre, of 0.6, a quarter of a period late: 0.042 / 2π of 0.749 m.
  EXPECT_NEAR(residualMultipath(multipath, 0.07f), 0.0050099f, 1e-6f);
  EXPECT_FLOAT_EQ(residualMultipath({0.5f * kFrequency, kReflectance}, 0.07f), 2 * residualMultipath(multipath, 0.07f));
  EXPECT_FLOAT_EQ(residualMultipath({kFrequency, 0.5f * kReflectance}, 0.07f),
                  0.5f * residualMultipath(multipath, 0.07f));
  EXPECT_EQ(residualMultipath({0, kReflectance}, 0.07f), 0.0f);

  // A view of a wall straight ahead, whose normals are the optical axis.
  const int size = 160;
  Camera lamp = lampCamera(size);
  const std::vector<float> z(static_cast<std::size_t>(size) * size, 2.0f);
  DepthView view;
  view.depth32 = {z.data(), size, size};
  const auto blocksOf = [&](const Camera& camera, float share) {
    ExtrinsicParameters p;
    p.residual_multipath = share;
    host::ViewGeometry geometry;
    geometry.assign(camera);
    auto blocks = std::make_unique<host::AlignmentView>();
    blocks->assign(geometry, view, p);
    return blocks;
  };
  const auto with = blocksOf(lamp, 0.07f), without = blocksOf(lamp, 0);
  lamp.multipath = {};
  const auto other = blocksOf(lamp, 0.07f);
  const int middle = with->width() / 2;
  const float noise = without->noise(middle, middle);
  EXPECT_EQ(other->noise(middle, middle), noise) << "other sensors have none";
  EXPECT_NEAR(with->noise(middle, middle), std::hypot(noise, 0.02004f), 2e-5f);  // 4 m² times 5.01 mm
  EXPECT_NEAR(with->image().axialDeviation(1), std::hypot(without->image().axialDeviation(1), 0.00501f), 1e-6f);

  // Two such views from one place: what noise and light leave of a residual is of both, and blocks leave half a millimetre.
  const AlignmentGates gates{0.25f, 3.0f, 0.7f, 1e9f, 0.0f, 40.0f, false, 0, 1};
  const auto deviationOf = [&](const host::AlignmentView& first, const host::AlignmentView& second) {
    Match match;
    EXPECT_TRUE(findMatch({}, {}, second.image(), sampleOf(first.image(), middle, middle), gates, match));
    EXPECT_NEAR(match.r, 0, 1e-6f);
    return 1 / match.per_sigma;
  };
  const float light = 0.02004f, of_both = std::hypot(std::hypot(noise, noise), 0.0005f);
  EXPECT_NEAR(deviationOf(*without, *without), of_both, 1e-6f);
  EXPECT_NEAR(deviationOf(*with, *without), std::hypot(of_both, light), 2e-5f);
  EXPECT_NEAR(deviationOf(*without, *with), std::hypot(of_both, light), 2e-5f);
  EXPECT_NEAR(deviationOf(*with, *with), std::hypot(std::hypot(of_both, light), light), 4e-5f);
}

TEST(Multipath, PosesOfARoomThatIsFarOutOfRangeAreTheBetterForIt) {
  if (kSanitized) GTEST_SKIP() << "the code of the test before";
  simulation::SimulationOptions options;
  options.scene = "table";
  options.rig = "ring-4";
  options.sensor = "time_of_flight_multipath";
  options.scale = 0.5;
  simulation::Simulator simulator(options);
  io::LoadedFrame frame;
  simulator.measure(0, frame);
  std::vector<Eigen::Isometry3d> truth;
  for (const Camera& camera : simulator.trueCameras()) truth.push_back(camera.T_world_camera);
  const auto farthest = [&](const ExtrinsicParameters& p) {
    ExtrinsicEstimation<PointFused> estimation;
    estimation.setParameters(p);
    estimation.addFrame(frame.rig);
    const std::vector<Eigen::Isometry3d> found = estimation.estimate(truth).T_world_camera;
    double most = 0;
    for (std::size_t i = 1; i < truth.size(); ++i)
      most = std::max(most, (found[i].translation() - truth[i].translation()).norm());
    return most;
  };
  ExtrinsicParameters trusting;
  trusting.residual_multipath = 0;
  const double by_all = farthest(trusting), by_near = farthest({});
  EXPECT_GT(by_all, 0.005);
  EXPECT_LT(by_near, 0.4 * by_all);
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
