#include "../refusal.h"
#include "../rigs.h"
#include "../sensors/wrong_sensors.h"

#include <fuse_flow/calibration/depth_correction_estimation.h>
#include <fuse_flow/calibration/extrinsic_estimation.h>
#include <fuse_flow/impl/calibration/correction_search.hpp>
#include <fuse_flow/point_types.h>

#include <limits>

using namespace fuse_flow;
using namespace scenes;
using refusal::expectThrow;

namespace {

/** \brief Wrong by some percent, left and right in opposite directions, the more the farther. */
DepthCorrection tilted(int columns, int rows, float sign = 1) {
  DepthCorrection c{columns, rows, {}, {}};
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) {
      const float right = 2 * static_cast<float>(x) / static_cast<float>(columns - 1) - 1;
      const float down = 2 * static_cast<float>(y) / static_cast<float>(rows - 1) - 1;
      c.relative.push_back(sign * (0.006f * right * down));
      c.per_metre.push_back(sign * (0.008f * right - 0.004f * down * down + 0.002f));
    }
  return c;
}

/** \brief Corners and balls at 1 to 3.5 m, seen by wrong sensors from around. The balls stand elsewhere at each instant. */
Scene instant(const std::vector<Camera>& cameras, const std::vector<DepthCorrection>& sensors, int t) {
  const double s = 0.25 * t;
  Scene scene = makeScene(
      cameras, nearest({plane({0, -1, 0}, -0.9), plane({-0.8, 0, -0.6}, -2.2), plane({0.6, 0, -0.8}, -2.3),
                        sphere({-0.5 + s, 0.3, 1.5 - s}, 0.3), sphere({0.6 - s, -0.2, 1.9 - 0.5 * s}, 0.35)}));
  for (std::size_t i = 0; i < scene.depth.size(); ++i) mismeasure(scene.depth[i], sensors[i]);
  addNoise(scene, 0.0015f, static_cast<unsigned int>(7 + t));
  scene.attach();
  return scene;
}

std::vector<Camera> around() {
  std::vector<Camera> cameras;
  for (int i = 0; i < 6; ++i) {
    const double x = 0.5 * (i - 2.5);
    cameras.push_back(lookAt({x, i % 2 ? -0.5 : 0.1, -0.3 + 0.1 * (i % 3)}, {0.3 * x, 0.1, 2}, 160, 120, 130));
    cameras.back().name = "test camera " + std::to_string(i);
  }
  return cameras;
}

constexpr int kInstants = 3;

std::unique_ptr<DepthCorrectionEstimation> measured(const std::vector<Camera>& cameras,
                                                    const std::vector<DepthCorrection>& sensors,
                                                    const DepthCorrectionParameters& parameters,
                                                    unsigned int threads = 2) {
  auto estimation = std::make_unique<DepthCorrectionEstimation>();
  estimation->setParameters(parameters);
  estimation->setNumberOfThreads(threads);
  for (int t = 0; t < kInstants; ++t) estimation->addFrame(instant(cameras, sensors, t).rig);
  return estimation;
}

DepthCorrectionParameters parameters(bool shared) {
  DepthCorrectionParameters p;
  p.shared = shared;
  p.columns = 5;
  p.rows = 4;
  return p;
}

/** \brief Root mean square distance between points as the cameras see them and their true places, after alignment of the scale and the pose
 *  of the whole rig, which are unobservable. */
double misplaced(const std::vector<Camera>& found, const std::vector<Camera>& truth,
                 const std::vector<DepthCorrection>& sensors) {
  std::vector<Vector3d> from, to;
  for (int t = 0; t < kInstants; ++t) {
    const Scene scene = instant(truth, sensors, t),
                exact = instant(truth, std::vector<DepthCorrection>(truth.size()), t);
    for (std::size_t i = 0; i < truth.size(); ++i)
      for (int v = 4; v < 116; v += 7)
        for (int u = 4; u < 156; u += 7) {
          if (exact.depth[i].at(u, v) > 3.5f) continue;  // a glance at a wall: few samples are so far away
          const auto z = static_cast<float>(
              simulation::mismeasured(static_cast<double>(exact.depth[i].at(u, v)), sensors[i].at(u, v, 160, 120)));
          const Intrinsics& K = truth[i].intrinsics;
          const Ray r = unproject(K, {static_cast<float>(u), static_cast<float>(v)});
          const Vector3d ray(static_cast<double>(r.x), static_cast<double>(r.y), 1);
          const float right = correctedDepth(z, found[i].depth_correction.at(u, v, 160, 120));
          from.push_back(found[i].T_world_camera * Vector3d(static_cast<double>(right) * ray));
          to.push_back(truth[i].T_world_camera * Vector3d(static_cast<double>(exact.depth[i].at(u, v)) * ray));
        }
  }
  Eigen::Matrix3Xd a(3, from.size()), b(3, to.size());
  for (std::size_t k = 0; k < from.size(); ++k) {
    a.col(static_cast<Eigen::Index>(k)) = from[k];
    b.col(static_cast<Eigen::Index>(k)) = to[k];
  }
  const Eigen::Matrix4d similarity = Eigen::umeyama(a, b, true);
  return std::sqrt(((similarity.topLeftCorner<3, 3>() * a).colwise() + similarity.topRightCorner<3, 1>() - b)
                       .colwise()
                       .squaredNorm()
                       .mean());
}

std::vector<Camera> off(std::vector<Camera> cameras) {
  for (std::size_t i = 1; i < cameras.size(); ++i)
    cameras[i].T_world_camera =
        moved(cameras[i].T_world_camera, Vector3d(0.006, -0.005, 0.004) * (i % 2 ? 1 : -1), 0.3, {1, i % 3 - 1.0, 0.5});
  return cameras;
}

TEST(DepthCorrectionEstimation, OneSensorCarriedAroundIsPutRight) {
  const std::vector<Camera> cameras = around();
  const std::vector<DepthCorrection> sensors(cameras.size(), tilted(5, 4));
  const DepthCorrectionResult result = measured(cameras, sensors, parameters(true))->estimate(poses(off(cameras)));
  EXPECT_TRUE(result.converged);
  EXPECT_LT(result.residual, 0.6 * result.residual_before);
  const double before = misplaced(off(cameras), cameras, sensors), after = misplaced(result.cameras, cameras, sensors);
  EXPECT_GT(before, 0.02);
  EXPECT_LT(after, 0.001);
  for (const Camera& camera : result.cameras)
    EXPECT_EQ(camera.depth_correction, result.cameras[0].depth_correction) << camera.name;
  for (const double observable : result.observable) EXPECT_GT(observable, 0.5);
}

TEST(DepthCorrectionEstimation, SensorsWithErrorsOfTheirOwnAreEachPutRight) {
  const std::vector<Camera> cameras = around();
  std::vector<DepthCorrection> sensors;
  for (std::size_t i = 0; i < cameras.size(); ++i) sensors.push_back(tilted(5, 4, i % 2 ? 1.0f : -1.0f));
  const DepthCorrectionResult result = measured(cameras, sensors, parameters(false))->estimate(poses(off(cameras)));
  EXPECT_LT(result.residual, 0.6 * result.residual_before);
  EXPECT_GT(misplaced(off(cameras), cameras, sensors), 0.02);
  EXPECT_LT(misplaced(result.cameras, cameras, sensors), 0.006);
  EXPECT_NE(result.cameras[0].depth_correction, result.cameras[1].depth_correction);
}

/** \brief What ExtrinsicEstimation makes of the same frames. */
std::vector<Eigen::Isometry3d> refinedPoses(const std::vector<Camera>& cameras,
                                            const std::vector<DepthCorrection>& sensors) {
  ExtrinsicEstimation<PointFused> estimation;
  estimation.setNumberOfThreads(2);
  for (int t = 0; t < kInstants; ++t) estimation.addFrame(instant(cameras, sensors, t).rig);
  return estimation.estimate().T_world_camera;
}

TEST(DepthCorrectionEstimation, BentDepthIsExplainedByCorrectionsAloneAndNoiseIsNot) {
  const std::vector<Camera> truth = around();
  std::vector<Eigen::Isometry3d> given;
  for (const Camera& camera : truth) given.push_back(camera.T_world_camera);
  for (const bool bent : {true, false}) {
    const std::vector<DepthCorrection> sensors(truth.size(), bent ? tilted(5, 4) : DepthCorrection{});
    const auto estimation = measured(truth, sensors, parameters(true));
    const DepthCorrectionResult result = estimation->estimate(given, refinedPoses(truth, sensors));
    EXPECT_TRUE(result.compared);
    EXPECT_EQ(result.explainsMore(), bent) << result.residual << ' ' << result.residual_of_poses;
    if (!bent) {
      EXPECT_NEAR(result.residual_of_poses, result.residual, 0.05 * result.residual);
    }
    EXPECT_NEAR(static_cast<double>(result.correspondences_of_poses), static_cast<double>(result.correspondences),
                0.1 * static_cast<double>(result.correspondences));
    // Over the same samples; and what is compared with changes nothing.
    const DepthCorrectionResult same = estimation->estimate(given, given);
    EXPECT_EQ(same.residual_of_poses, same.residual_before);
    EXPECT_EQ(same.residual, result.residual);
    const DepthCorrectionResult alone = estimation->estimate();
    EXPECT_FALSE(alone.compared);
    EXPECT_FALSE(alone.explainsMore());
    EXPECT_EQ(alone.residual, result.residual);
    EXPECT_EQ(alone.cameras[1].depth_correction.relative, result.cameras[1].depth_correction.relative);
  }
}

TEST(DepthCorrectionEstimation, CorrectionsExplainMoreIfViewsAgreeBetterInAsManyPlaces) {
  const auto explains = [](double residual, std::size_t matches, double of_poses, std::size_t correspondences_of_poses,
                           double gain = 0.05) {
    DepthCorrectionResult result;
    result.compared = true;
    result.residual = residual;
    result.correspondences = matches;
    result.residual_of_poses = of_poses;
    result.correspondences_of_poses = correspondences_of_poses;
    return result.explainsMore(gain);
  };
  EXPECT_TRUE(explains(0.94, 1000, 1, 1000));
  EXPECT_FALSE(explains(0.96, 1000, 1, 1000));
  EXPECT_TRUE(explains(0.96, 1000, 1, 1000, 0.03));
  EXPECT_FALSE(explains(0.94, 1000, 1, 1000, 0.1));
  EXPECT_TRUE(explains(0.94, 910, 1, 1000));
  EXPECT_FALSE(explains(0.1, 890, 1, 1000));  // led astray: little is left to disagree
  EXPECT_TRUE(explains(1.2, 1000, 1, 890));   // so were the poses alone
  EXPECT_FALSE(explains(0, 0, 1, 1000));      // nothing corresponds any more
  EXPECT_FALSE(explains(0, 0, 0, 0));
  EXPECT_TRUE(explains(1, 1000, 0, 0));
  EXPECT_FALSE(explains(std::numeric_limits<double>::quiet_NaN(), 1000, 1, 1000));
}

TEST(DepthCorrectionEstimation, RightSensorsAreLeftAlone) {
  const std::vector<Camera> cameras = around();
  const std::vector<DepthCorrection> sensors(cameras.size());
  for (const bool shared : {true, false}) {
    const DepthCorrectionResult result = measured(cameras, sensors, parameters(shared))->estimate();
    EXPECT_LT(misplaced(result.cameras, cameras, sensors), shared ? 0.0005 : 0.001) << shared;
  }
}

TEST(CorrectedBlock, TakesItsOwnNoiseBackAsTheCorrectionStretchesIt) {
  // Right depth 2.4 m of 2 m that noise made 2.01: against an exact plane all of the residual is noise.
  const auto f = [](double z) { return z * (1 + 0.02 + 0.09 * z); };
  for (const double along : {-1.0, -0.4, 0.7}) {
    host::CorrectedBlock block = host::correctBlock({}, 2.01f, 0.02, 0.09);
    EXPECT_NEAR(block.z_right, f(2.01), 1e-6);
    const double residual = along * (f(2.01) - f(2));
    block.takeBack(static_cast<float>(residual), static_cast<float>(along));
    EXPECT_NEAR(block.z_likely, 2.0, 2e-5) << along;  // without the stretch: 0.004 off
  }
}

TEST(CorrectedPair, SharesTheResidualAsTheNormalSeesNoise) {
  // Both sensors are alike and measure 2 m; the one looks along the normal, the other slants by 60° and its correction stretches noise by 1.2:
  // variances as 1 to 0.36. Together they put the surface where neither is blamed for more than that.
  BlockImage image;
  image.noise.floor = 0.004f;
  image.noise.quadratic = 0;
  host::CorrectedPair pair{};
  pair.own.z = pair.own.z_right = pair.other.z = pair.other.z_right = 2;
  pair.own.growth = 1;
  pair.other.growth = 1.2f;
  pair.along_own = -1;
  pair.along_other = 0.5f;
  pair.r = 0.0136f;
  const float variance = pair.shareResidual(image, image);
  EXPECT_NEAR(variance, 16e-6f * 1.36f + kBlockFloor * kBlockFloor, 1e-10f);
  EXPECT_NEAR(pair.own.z_likely, 2.010f, 2e-4f);
  EXPECT_NEAR(pair.other.z_likely, 2 - 0.0036f / 0.6f, 2e-4f);
}

TEST(CorrectedPair, NoiseIsThatOfWhereBothPutTheSurface) {
  // σ = z²/100. The other measurement is exact: all of the residual is the own one's, whose depth without noise is 2 m.
  BlockImage noisy, exact;
  noisy.noise.floor = exact.noise.floor = exact.noise.quadratic = 0;
  noisy.noise.quadratic = 0.01f;
  for (const float measured : {1.9f, 2.1f}) {
    host::CorrectedPair pair{};
    pair.own = host::correctBlock({}, measured, 0, 0);
    pair.other = host::correctBlock({}, 2, 0, 0);
    pair.along_own = -1;
    pair.along_other = 1;
    pair.r = 2 - measured;
    EXPECT_NEAR(std::sqrt(pair.shareResidual(noisy, exact)), 0.04f, 1e-4f)
        << measured;  // at 1.9 and 2.1 m: 0.036 and 0.044
  }
}

TEST(DepthCorrectionEstimation, ScaleStaysOnAverage) {
  const std::vector<Camera> cameras = around();
  DepthCorrection larger = tilted(5, 4);
  for (float& a : larger.relative) a += 0.05f;
  const std::vector<DepthCorrection> sensors(cameras.size(), larger);
  const DepthCorrectionResult result = measured(cameras, sensors, parameters(true))->estimate();
  double sum = 0, n = 0;
  for (int t = 0; t < kInstants; ++t) {
    const Scene scene = instant(cameras, sensors, t);
    for (std::size_t i = 0; i < cameras.size(); ++i)
      for (int v = 10; v < 110; v += 5)
        for (int u = 10; u < 150; u += 5) {
          const float z = scene.depth[i].at(u, v);
          if (!(z > 0)) continue;
          sum += static_cast<double>(correctedDepth(z, result.cameras[i].depth_correction.at(u, v, 160, 120)) / z - 1);
          n += 1;
        }
  }
  EXPECT_LT(std::fabs(sum / n), 0.004);  // samples are even over normals, not over the image
}

TEST(DepthCorrectionEstimation, MoreInstantsThanCountTellNoMore) {
  // The same frames again and again: as much as those alone where no more of them count, and else more than what is believed.
  const std::vector<Camera> truth = around();
  const std::vector<DepthCorrection> sensors(truth.size(), tilted(5, 4));
  // \param silent more frames, in which no camera measures
  const auto knots = [&](int times, int effective_instants, int silent = 0) {
    DepthCorrectionParameters p = parameters(true);
    p.views.max_iterations = 12;
    p.effective_instants = effective_instants;
    DepthCorrectionEstimation estimation;
    estimation.setParameters(p);
    for (int k = 0; k < times; ++k)
      for (int t = 0; t < 2; ++t) estimation.addFrame(instant(truth, sensors, t).rig);
    for (int k = 0; k < silent; ++k) {
      Scene scene = instant(truth, sensors, 0);
      for (DepthView& view : scene.rig.views) view = {};
      estimation.addFrame(scene.rig);
    }
    return estimation.estimate().cameras[0].depth_correction.per_metre;
  };
  const auto largestDifference = [](const std::vector<float>& a, const std::vector<float>& b) {
    float largest = 0;
    for (std::size_t k = 0; k < a.size(); ++k) largest = std::max(largest, std::fabs(a[k] - b[k]));
    return largest;
  };
  const std::vector<float> once = knots(1, 2);
  EXPECT_LT(largestDifference(knots(4, 2), once), 1e-6f);
  EXPECT_LT(largestDifference(knots(1, 8), once), 1e-6f);
  EXPECT_GT(largestDifference(knots(4, 8), once), 1e-4f);
  EXPECT_LT(largestDifference(knots(1, 2, 20), once), 1e-6f);  // who does not measure does not count
}

TEST(DepthCorrectionEstimation, ThreadsDoNotMatter) {
  std::vector<Camera> cameras = around();
  if (scenes::kSanitized) cameras.resize(2);
  const std::vector<DepthCorrection> sensors(cameras.size(), tilted(5, 4));
  const DepthCorrectionResult one = measured(cameras, sensors, parameters(false), 1)->estimate();
  const DepthCorrectionResult many = measured(cameras, sensors, parameters(false), 3)->estimate();
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    EXPECT_EQ(one.cameras[i].depth_correction, many.cameras[i].depth_correction);
    EXPECT_EQ(one.cameras[i].T_world_camera.matrix(), many.cameras[i].T_world_camera.matrix());
  }
}

TEST(DepthCorrectionEstimation, WhereTheWorldsOriginIsDoesNotMatter) {
  const std::vector<Camera> cameras = around();
  const std::vector<DepthCorrection> sensors(cameras.size(), tilted(5, 4));
  const auto estimation = measured(cameras, sensors, parameters(true));
  const DepthCorrectionResult here = estimation->estimate();
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  motion.translate(Vector3d(40, -20, 5)).rotate(Eigen::AngleAxisd(0.5, Vector3d(1, 2, 3).normalized()));
  std::vector<Eigen::Isometry3d> elsewhere = poses(cameras);
  for (Eigen::Isometry3d& T : elsewhere) T = motion * T;
  const DepthCorrectionResult there = estimation->estimate(elsewhere);
  // Other normals fall into other bins: other samples.
  for (std::size_t k = 0; k < 20; ++k) {
    EXPECT_NEAR(here.cameras[0].depth_correction.per_metre[k], there.cameras[0].depth_correction.per_metre[k], 2e-3);
    EXPECT_NEAR(here.cameras[0].depth_correction.relative[k], there.cameras[0].depth_correction.relative[k], 4e-3);
  }
}

TEST(DepthCorrectionEstimation, WhatTwoViewsOfOneWallLeaveOpenStays) {
  std::vector<Camera> cameras = cameraRow(2, 160, 120, 130);
  Scene scene = makeScene(cameras, plane({0, 0, 1}, 1.5));
  for (float& z : scene.depth[0].data) z *= 1.01f;
  addNoise(scene, 0.001f);
  DepthCorrectionEstimation estimation;
  estimation.addFrame(scene.rig);
  const DepthCorrectionResult result = estimation.estimate();
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_LT(apart(result.cameras[i].T_world_camera, cameras[i].T_world_camera), 0.02) << i;
    EXPECT_LT(turned(result.cameras[i].T_world_camera, cameras[i].T_world_camera), 0.8) << i;
    for (std::size_t k = 0; k < 48; ++k)
      EXPECT_LT(std::fabs(result.cameras[i].depth_correction.relative[k] +
                          1.5f * result.cameras[i].depth_correction.per_metre[k]),
                0.02f);
  }
}

TEST(DepthCorrectionEstimation, ViewsThatShareNothingAreGivenBackAsTheyCame) {
  std::vector<Camera> cameras = cameraRow(2, 160, 120, 130);
  cameras[1].T_world_camera = Eigen::Translation3d(50, 0, 0) * cameras[1].T_world_camera;
  Scene scene = makeScene(cameras, plane({0, 0, 1}, 1.5));
  DepthCorrectionEstimation estimation;
  estimation.addFrame(scene.rig);
  const auto unchanged = [&](const DepthCorrectionResult& result) {
    for (std::size_t i = 0; i < result.cameras.size(); ++i) {
      EXPECT_LT(apart(result.cameras[i].T_world_camera, scene.rig.cameras[i].T_world_camera), 1e-9);
      for (const float a : result.cameras[i].depth_correction.relative) EXPECT_EQ(a, 0.0f);
      EXPECT_EQ(result.observable[i], 0.0);
    }
  };
  unchanged(estimation.estimate());
  estimation.clear();
  scene.rig.cameras.resize(1);
  scene.rig.views.resize(1);
  estimation.addFrame(scene.rig);  // one camera
  unchanged(estimation.estimate());
  estimation.clear();
  Scene empty = makeFlatScene(cameraRow(3, 160, 120, 130), {0, 0, 0});
  empty.rig.views[1] = {};  // nothing measured, and a camera missing
  estimation.addFrame(empty.rig);
  EXPECT_EQ(estimation.estimate().residual, 0.0);
  EXPECT_EQ(estimation.estimate().correspondences, 0u);
}

TEST(DepthCorrectionEstimation, CorrectionsThatCamerasHaveAreFoundAnew) {
  const std::vector<Camera> cameras = around();
  const std::vector<DepthCorrection> sensors(cameras.size(), tilted(5, 4));
  std::vector<Camera> corrected = cameras;
  for (Camera& camera : corrected) camera.depth_correction = tilted(3, 3, -2);
  const DepthCorrectionResult from_none = measured(cameras, sensors, parameters(true))->estimate();
  const DepthCorrectionResult from_some = measured(corrected, sensors, parameters(true))->estimate();
  EXPECT_EQ(from_none.cameras[0].depth_correction, from_some.cameras[0].depth_correction);
}

TEST(DepthCorrectionEstimation, RefusesWhatItCannotUse) {
  DepthCorrectionEstimation estimation;
  expectThrow<pcl::PCLException>([&] { estimation.estimate(); }, {"no frame"});
  const Scene scene = wall(2);
  estimation.addFrame(scene.rig);
  expectThrow([&] { estimation.estimate({Eigen::Isometry3d::Identity()}); }, {"1 poses for 2 cameras"});
  const auto refuses = [](auto&& change, const std::string& name) {
    DepthCorrectionParameters p;
    change(p);
    expectThrow([&] { DepthCorrectionEstimation().setParameters(p); }, {"DepthCorrectionEstimation", name});
  };
  refuses([](DepthCorrectionParameters& p) { p.columns = 1; }, "columns");
  refuses([](DepthCorrectionParameters& p) { p.rows = 65; }, "rows");
  refuses([](DepthCorrectionParameters& p) { p.magnitude = 0; }, "magnitude");
  refuses([](DepthCorrectionParameters& p) { p.roughness = -1; }, "roughness");
  refuses([](DepthCorrectionParameters& p) { p.pose_deviation = std::nanf(""); }, "pose_deviation");
  refuses([](DepthCorrectionParameters& p) { p.redundancy = 0.5f; }, "redundancy");
  refuses([](DepthCorrectionParameters& p) { p.effective_instants = 0; }, "effective_instants");
}

}  // namespace
