#include "../scenes.h"

#include <fuse_flow/math/noise_scale.h>

namespace {

using fuse_flow::FrameStatistics;
using fuse_flow::FuseFlowParameters;
using scenes::Cloud;
using scenes::Scene;

// ---- The equations, by hand

float smoothed(std::array<float, 9> q, float tolerance) {
  float patch[9];
  std::copy(q.begin(), q.end(), patch);
  return fuse_flow::smoothedInverseDepth(patch, tolerance);
}

TEST(Smoothing, OnePairAtHalfTheToleranceWeighsAsTukeysBiweightSays) {
  // r = 0.1, t = 0.2: w = (1 − 1/4)² = 0.5625; the other pairs have holes.
  const float expected = 1.0f + 0.5625f * 0.1f / (1 + 2 * 0.5625f);
  EXPECT_NEAR(smoothed({0, 0, 0, 1.02f, 1, 1.08f, 0, 0, 0}, 0.2f), expected, 1e-6f);
  EXPECT_NEAR(smoothed({0, 1.02f, 0, 0, 1, 0, 0, 1.08f, 0}, 0.2f), expected, 1e-6f);
  EXPECT_NEAR(smoothed({1.02f, 0, 0, 0, 1, 0, 0, 0, 1.08f}, 0.2f), expected, 1e-6f);
  EXPECT_NEAR(smoothed({0, 0, 1.02f, 0, 1, 0, 1.08f, 0, 0}, 0.2f), expected, 1e-6f);
}

TEST(Smoothing, NormalsOfNoisyViewsAreTakenFromFartherPixels) {
  fuse_flow::SmoothingParameters parameters;
  parameters.wide_above = 1.8f;
  EXPECT_EQ(normalSpacing(parameters, 1.7f), 1);
  EXPECT_EQ(normalSpacing(parameters, 1.9f), 4);
}

TEST(Smoothing, AllNeighboursAtOnceAreTheMeanForALargeTolerance) {
  EXPECT_NEAR(smoothed({1, 2, 3, 4, 5, 6, 7, 8, 18}, 1e6f), 6.0f, 1e-4f);
}

TEST(Smoothing, APairCountsOnlyWholeAndOnlyWithinTheTolerance) {
  EXPECT_EQ(smoothed({0, 0, 0, 1.1f, 1, 0, 0, 0, 0}, 0.2f), 1.0f);     // one of the two is a hole
  EXPECT_EQ(smoothed({0, 0, 0, 1.5f, 1, 1.5f, 0, 0, 0}, 0.2f), 1.0f);  // beyond a jump
  EXPECT_EQ(smoothed({0, 0, 0, 0.5f, 1, 1.5f, 0, 0, 0}, 0.2f), 1.0f);  // a steep plane: r = 0
}

TEST(Smoothing, TheToleranceShrinksFromPassToPassAndGrowsWithTheNoise) {
  fuse_flow::SmoothingParameters p;
  p.tolerance = 2;
  p.shrink = 0.5f;
  EXPECT_NEAR(fuse_flow::smoothingTolerance(p, 0, 1), 2 * std::sqrt(6.0f), 1e-5f);
  EXPECT_NEAR(fuse_flow::smoothingTolerance(p, 3, 4), std::sqrt(6.0f), 1e-5f);
}

TEST(Smoothing, TheSpacingDoublesFromPassToPassAndInNoisyViews) {
  fuse_flow::SmoothingParameters p;
  p.wide_above = 2;
  for (const auto& [pass, usual, noisy] : {std::array{0, 1, 2}, {1, 2, 4}, {2, 4, 8}, {3, 8, 16}}) {
    EXPECT_EQ(fuse_flow::smoothingStep(p, pass, 1.5f), usual);
    EXPECT_EQ(fuse_flow::smoothingStep(p, pass, 2.0f), usual);
    EXPECT_EQ(fuse_flow::smoothingStep(p, pass, 2.1f), noisy);
    EXPECT_LE(noisy, fuse_flow::kMaxSmoothingStep);
  }
}

TEST(Smoothing, TwicingRunsThePassesButTheFirstOnceMore) {
  fuse_flow::SmoothingParameters p;
  p.passes = 4;
  p.tolerance = 1;
  p.shrink = 0.5f;
  EXPECT_EQ(fuse_flow::smoothingPasses(p), 7);
  for (const auto& [pass, repeated] : {std::array{0, 0}, {3, 3}, {4, 1}, {5, 2}, {6, 3}}) {
    EXPECT_EQ(fuse_flow::smoothingStep(p, pass, 1), 1 << repeated);
    EXPECT_FLOAT_EQ(fuse_flow::smoothingTolerance(p, pass, 1), std::sqrt(6.0f) / static_cast<float>(1 << repeated));
  }
  p.twicing = false;
  EXPECT_EQ(fuse_flow::smoothingPasses(p), 4);
  p.twicing = true;
  for (const auto& [passes, all] : {std::array{0, 0}, {1, 1}, {2, 4}, {3, 5}, {4, 7}}) {
    p.passes = passes;
    EXPECT_EQ(fuse_flow::smoothingPasses(p), all);
  }
}

TEST(Smoothing, NoPassReadsTheMapThatItWritesAndThoseOfTwicingLeaveWhatWasBeforeThem) {
  fuse_flow::SmoothingParameters p;
  for (p.passes = 0; p.passes <= fuse_flow::kMaxSmoothingPasses; ++p.passes)
    for (const bool twicing : {false, true}) {
      p.twicing = twicing;
      EXPECT_EQ(fuse_flow::smoothingMap(p, 0), 0);
      for (int pass = 0; pass < fuse_flow::smoothingPasses(p); ++pass) {
        const int written = fuse_flow::smoothingMap(p, pass + 1);
        EXPECT_NE(fuse_flow::smoothingMap(p, pass), written);
        EXPECT_LE(written, pass < p.passes ? 1 : 2);
        if (pass < p.passes) continue;
        EXPECT_NE(fuse_flow::smoothingMap(p, p.passes), written);
      }
    }
}

/** \brief On a surface that continues along its row. */
float twiced(const fuse_flow::SmoothingParameters& p, float smoothed, float again, float noise) {
  return fuse_flow::twicedInverseDepth(p, {smoothed, smoothed, smoothed, 0, 0}, again, noise);
}

TEST(Smoothing, TwicingSubtractsWhatIsMoreThanNoise) {
  fuse_flow::SmoothingParameters p;
  p.passes = 4;
  const float k = (1 + 4 + 16 + 64) / (4 + 16 + 64.0f);  // Σ h² of all passes over that of those which run twice
  p.twicing_above = 0;
  EXPECT_FLOAT_EQ(twiced(p, 1, 1.01f, 0.1f), 1 - k * 0.01f);
  EXPECT_FLOAT_EQ(twiced(p, 1, 0.99f, 0.1f), 1 + k * 0.01f);
  EXPECT_EQ(twiced(p, 1, 1, 0.1f), 1.0f);
  p.twicing_above = 0.5f;
  EXPECT_NEAR(twiced(p, 1, 1 + 0.005f / k, 0.01f), 1 - 0.0025f, 1e-6f);  // half of a change of half the noise
  EXPECT_NEAR(twiced(p, 1, 1 + 0.0005f / k, 0.01f), 1, 1e-6f);           // noise
  EXPECT_NEAR(twiced(p, 1, 1 + 0.05f / k, 0.01f), 1 - 0.05f, 1e-5f);     // curvature
  EXPECT_EQ(twiced(p, 0.01f, 1, 0.001f), 0.01f);                         // nothing comes to lie behind the camera
  p.twicing_above = 0;
  for (const auto& [passes, factor] : {std::pair(3, (1 + 4 + 16) / (4 + 16.0f)), {2, 1.0f}}) {
    p.passes = passes;
    EXPECT_FLOAT_EQ(twiced(p, 1, 1.01f, 0.1f), 1 - factor * 0.01f) << passes << " passes";
  }
}

TEST(Smoothing, TwicingTakesASecondDifferenceAsLargeAsTheChangeForCurvature) {
  fuse_flow::SmoothingParameters p;
  p.passes = 2;  // the change is again − smoothed, with nothing rounded
  p.twicing_above = 0;
  const auto twice = [&p](float beside) {
    return fuse_flow::twicedInverseDepth(p, {1, beside, beside, 0, 0}, 1.25f, 1);
  };
  EXPECT_EQ(twice(1.125f), 0.75f);  // a second difference of a quarter
  EXPECT_EQ(twice(0.875f), 0.75f);
  EXPECT_EQ(twice(std::nextafter(1.125f, 2.0f)), 1.0f);
}

TEST(Smoothing, NoneOfTheThreeMapsIsReadByTheWrongPass) {
  fuse_flow::SmoothingParameters p;
  for (const auto& [passes, expected] :
       {std::pair(4, std::vector<int>{0, 1, 0, 1, 0, 1, 2, 1}), {3, {0, 1, 0, 1, 0, 2}}, {2, {0, 1, 0, 1, 2}}}) {
    p.passes = passes;
    ASSERT_EQ(fuse_flow::smoothingPasses(p) + 1, static_cast<int>(expected.size()));
    for (int pass = 0; pass < static_cast<int>(expected.size()); ++pass)
      EXPECT_EQ(fuse_flow::smoothingMap(p, pass), expected[static_cast<std::size_t>(pass)])
          << passes << " passes, " << pass;
  }
}

TEST(Smoothing, TwicingLeavesAPixelThatSticksOutByItself) {
  fuse_flow::SmoothingParameters p;
  const auto twice = [&p](float left, float right, float above, float below) {
    return fuse_flow::twicedInverseDepth(p, {1, left, right, above, below}, 1.02f, 0.001f);
  };
  const float curved = twice(1, 1, 1, 1);
  EXPECT_NEAR(curved, 1 - 0.02f * 85 / 84, 1e-5f);
  EXPECT_EQ(twice(1.01f, 1.01f, 1.01f, 1.01f), curved);  // a second difference of 0.02, the change is more
  EXPECT_EQ(twice(1.05f, 1.05f, 1.05f, 1.05f), 1.0f);    // sticks out on all sides
  EXPECT_EQ(twice(0.95f, 0.95f, 0.95f, 0.95f), 1.0f);
  EXPECT_EQ(twice(1.05f, 0.95f, 1.05f, 1.05f), curved);  // a slope along the row
  EXPECT_EQ(twice(1.05f, 1.05f, 1.0f, 1.0f), curved);    // a ridge along the column
  EXPECT_EQ(twice(2, 1, 1, 1), curved);                  // an edge on the left
  EXPECT_EQ(twice(2, 1, 1, 2), 1.0f);                    // a corner
  EXPECT_EQ(twice(0, 1, 1, 1), curved);                  // holes
  EXPECT_EQ(twice(0, 1, 1, 0), 1.0f);
}

TEST(Smoothing, InverseDepthNoiseIsDepthNoiseOverDepthSquared) {
  const fuse_flow::NoiseModel p{0.0005f, 0.002f, 0.001425f};
  for (const float z : {0.3f, 1.0f, 7.0f})
    EXPECT_NEAR(fuse_flow::inverseDepthNoise(p, 1 / z), fuse_flow::axialNoise(p, z) / (z * z), 1e-7f);
}

TEST(NoiseWeight, NoiseOfHalfWeightHalvesAndFarAboveItTheWeightIsInverseVariance) {
  EXPECT_FLOAT_EQ(fuse_flow::noiseWeight(0.025f, 1 / 0.025f), 0.5f);
  EXPECT_EQ(fuse_flow::noiseWeight(0.5f, 0), 1.0f);
  EXPECT_NEAR(fuse_flow::noiseWeight(4, 100) / fuse_flow::noiseWeight(2, 100), 0.25f, 1e-4f);
}

TEST(NoiseScale, EachBinBeginsWhereItSaysAndIsATwentiethWideAtMost) {
  for (int bin = 0; bin < fuse_flow::kNoiseBins; ++bin) {
    const float begin = fuse_flow::noiseBinBegin(bin), end = fuse_flow::noiseBinBegin(bin + 1);
    EXPECT_EQ(fuse_flow::noiseBin(begin), bin);
    EXPECT_EQ(fuse_flow::noiseBin(std::nextafter(end, 0.0f)), bin);
    EXPECT_LE(end / begin, 1.05f);
  }
  EXPECT_EQ(fuse_flow::noiseBin(0), 0);
  EXPECT_EQ(fuse_flow::noiseBin(1e9f), fuse_flow::kNoiseBins - 1);
  EXPECT_EQ(fuse_flow::noiseBinBegin(0), 1.0f / 64);
  EXPECT_EQ(fuse_flow::noiseBinBegin(fuse_flow::kNoiseBins), 64.0f);
}

TEST(NoiseScale, IsTheMedianOverThatOfANormalDistribution) {
  std::vector<std::uint32_t> counts(fuse_flow::kNoiseBins, 0);
  counts[static_cast<std::size_t>(fuse_flow::noiseBin(1.0f))] = 99;
  EXPECT_EQ(fuse_flow::noiseScale(counts.data()), 1.0f);              // too few to say
  counts[static_cast<std::size_t>(fuse_flow::noiseBin(1.0f))] = 200;  // [1, 1 + 1/32): its middle
  EXPECT_NEAR(fuse_flow::noiseScale(counts.data()), (1 + 1.0f / 64) / 0.6745f, 1e-4f);
  counts[0] = 1000;  // most differences are nothing
  EXPECT_EQ(fuse_flow::noiseScale(counts.data()), fuse_flow::kMinNoiseScale);
  counts[fuse_flow::kNoiseBins - 1] = 5000;
  EXPECT_EQ(fuse_flow::noiseScale(counts.data()), fuse_flow::kMaxNoiseScale);
}

TEST(NoiseScale, AHundredDifferencesAreEnough) {
  std::vector<std::uint32_t> counts(fuse_flow::kNoiseBins, 0);
  counts[static_cast<std::size_t>(fuse_flow::noiseBin(2.0f))] = fuse_flow::kMinNoiseSamples;
  EXPECT_GT(fuse_flow::noiseScale(counts.data()), 2.0f);
  --counts[static_cast<std::size_t>(fuse_flow::noiseBin(2.0f))];
  EXPECT_EQ(fuse_flow::noiseScale(counts.data()), 1.0f);
}

TEST(NoiseScale, HalfOfTheDifferencesAreBeforeTheMedian) {
  // Half of them in one bin: the median is where that one ends.
  std::vector<std::uint32_t> counts(fuse_flow::kNoiseBins, 0);
  const auto first = static_cast<std::size_t>(fuse_flow::noiseBin(1.0f)),
             second = static_cast<std::size_t>(fuse_flow::noiseBin(1.5f));
  counts[first] = counts[second] = 100;
  EXPECT_FLOAT_EQ(fuse_flow::noiseScale(counts.data()), (1 + 1.0f / 32) / 0.6745f);
  counts[second] = 300;  // its middle third begins there
  EXPECT_FLOAT_EQ(fuse_flow::noiseScale(counts.data()), (1.5f + (1.0f / 32) / 3) / 0.6745f);
  // Beyond all bins: the last one that has any.
  counts.assign(fuse_flow::kNoiseBins, 0);
  counts[fuse_flow::kNoiseBins - 2] = 1000;
  EXPECT_EQ(fuse_flow::noiseScale(counts.data()), fuse_flow::kMaxNoiseScale);
}

// ---- The refined depth of a frame, seen through the point-wise fusion: one point a pixel, nothing averaged

FuseFlowParameters onePointAPixel(int passes = 4) {
  FuseFlowParameters p;
  p.use_spatial_hash = p.use_distance_consistency = p.use_measurement_confidence = false;
  p.smoothing.passes = passes;
  return p;
}

scenes::Surface tiltedPlane() { return scenes::plane(scenes::Vector3d(0.5, -0.3, 1).normalized(), 1.7); }

/** \brief A camera of a depth sensor's angular resolution. */
std::vector<fuse_flow::Camera> oneCamera() { return scenes::sameCameras(1, 160, 120, 260); }

/** \brief Standard deviation and mean of z against the plane, 20 pixels away from the image's border. */
std::array<double, 2> errorOf(const Cloud& cloud, const fuse_flow::io::FloatImage& exact) {
  double sum = 0, squares = 0, n = 0;
  for (int v = 20; v < exact.height - 20; ++v)
    for (int u = 20; u < exact.width - 20; ++u) {
      const double e = static_cast<double>(cloud[static_cast<std::size_t>(v * exact.width + u)].z) -
                       static_cast<double>(exact.at(u, v));
      sum += e;
      squares += e * e;
      ++n;
    }
  return {std::sqrt(squares / n - sum * sum / (n * n)), sum / n};
}

TEST(Refinement, LeavesAnInclinedPlaneExactlyWhereItIs) {
  const Scene scene = scenes::makeScene(oneCamera(), tiltedPlane());
  const Cloud cloud = scenes::fuse(scene.rig, onePointAPixel());
  ASSERT_EQ(cloud.size(), scene.depth[0].data.size());
  for (std::size_t k = 0; k < cloud.size(); ++k) ASSERT_NEAR(cloud[k].z, scene.depth[0].data[k], 3e-6f);
}

TEST(Refinement, IsThatOfEachCameraAloneWhateverOthersThereAreAndTheirSizes) {
  std::vector<fuse_flow::Camera> cameras;
  for (const auto& [width, height] : {std::pair(96, 72), std::pair(160, 120), std::pair(64, 90), std::pair(160, 120)})
    cameras.push_back(scenes::sameCameras(1, width, height, 1.6f * static_cast<float>(width))[0]);
  Scene scene = scenes::makeScene(cameras, tiltedPlane());
  scenes::addNoise(scene, 0.004f);
  for (int passes = 0; passes <= 4; ++passes) {
    Cloud alone;
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      fuse_flow::RigFrame frame;
      frame.cameras = {scene.rig.cameras[i]};
      frame.views = {scene.rig.views[i]};
      alone += scenes::fuse(frame, onePointAPixel(passes));
    }
    for (const unsigned int threads : {1u, 3u})
      EXPECT_TRUE(scenes::bytes(scenes::fuse(scene.rig, onePointAPixel(passes), threads)) == scenes::bytes(alone))
          << passes << " passes, " << threads << " threads";
  }
}

TEST(Refinement, TakesTheNoiseOffAnInclinedPlaneAndShiftsItByNothing) {
  const Scene exact = scenes::makeScene(oneCamera(), tiltedPlane());
  for (const float sigma : {0.002f, 0.005f, 0.012f}) {  // the sensor is expected to have 4 to 7 mm
    Scene scene = scenes::makeScene(oneCamera(), tiltedPlane());
    scenes::addNoise(scene, sigma);
    const auto before = errorOf(scenes::fuse(scene.rig, onePointAPixel(0)), exact.depth[0]);
    const auto after = errorOf(scenes::fuse(scene.rig, onePointAPixel()), exact.depth[0]);
    EXPECT_NEAR(before[0], static_cast<double>(sigma), 0.05 * static_cast<double>(sigma));
    EXPECT_LT(after[0], 0.25 * before[0]);
    EXPECT_LT(std::abs(after[1]), 0.05 * before[0]);
  }
}

TEST(Refinement, TwicingKeepsABallAsLargeAsItIsAndAPlaneNearlyAsSmooth) {
  const float sigma = 0.003f;
  const scenes::Vector3d center(0, 0, 1.5);
  const double radius = 0.2;
  const Scene exact_plane = scenes::makeScene(oneCamera(), tiltedPlane());
  Scene ball = scenes::makeScene(oneCamera(), scenes::sphere(center, radius));
  Scene plane = scenes::makeScene(oneCamera(), tiltedPlane());
  scenes::addNoise(ball, sigma);
  scenes::addNoise(plane, sigma);
  /** Mean distance outside of the ball, away from its outline. */
  const auto outside = [&](const FuseFlowParameters& parameters) {
    double sum = 0, n = 0;
    for (const auto& point : scenes::fuse(ball.rig, parameters)) {
      const scenes::Vector3d p = point.getVector3fMap().cast<double>() - center;
      if (p.head<2>().norm() > 0.5 * radius) continue;
      sum += p.norm() - radius;
      ++n;
    }
    EXPECT_GT(n, 500);
    return sum / n;
  };
  for (const int passes : {2, 3, 4}) {
    FuseFlowParameters with = onePointAPixel(passes), without = with;
    without.smoothing.twicing = false;
    const double thin = outside(without);
    EXPECT_LT(thin, passes == 2 ? -0.0015 : -0.006);
    EXPECT_LT(std::abs(outside(with)), (passes == 2 ? 0.45 : 0.05) * std::abs(thin)) << passes << " passes";
    const double noise = errorOf(scenes::fuse(plane.rig, with), exact_plane.depth[0])[0];
    EXPECT_LT(noise, (passes == 2 ? 1.1 : 1.05) * errorOf(scenes::fuse(plane.rig, without), exact_plane.depth[0])[0])
        << passes << " passes";
  }
}

/** \brief Adds to the depth what blocks of 8×8 pixels have in common. */
void addNoiseOfBlocks(Scene& scene, float sigma) {
  std::mt19937 random(5);
  std::normal_distribution<float> noise(0.0f, sigma);
  for (fuse_flow::io::FloatImage& depth : scene.depth)
    for (int v = 0; v < depth.height; v += 8)
      for (int u = 0; u < depth.width; u += 8) {
        const float error = noise(random);
        for (int k = 0; k < 64; ++k) depth.at(u + k % 8, v + k / 8) += error;
      }
}

TEST(Refinement, AveragesOverTwiceTheSpacingWhereNeighboursShareTheNoiseOfAStrongOne) {
  const Scene exact = scenes::makeScene(oneCamera(), tiltedPlane());
  const float sigma = 2.5f * fuse_flow::axialNoise(fuse_flow::NoiseModel(), 1.7f);
  Scene scene = scenes::makeScene(oneCamera(), tiltedPlane());
  addNoiseOfBlocks(scene, sigma);
  FuseFlowParameters parameters = onePointAPixel();
  const double wide = errorOf(scenes::fuse(scene.rig, parameters), exact.depth[0])[0];
  parameters.smoothing.wide_above = 8;
  const double narrow = errorOf(scenes::fuse(scene.rig, parameters), exact.depth[0])[0];
  EXPECT_LT(wide, 0.5 * static_cast<double>(sigma));
  EXPECT_LT(wide, 0.75 * narrow);
}

TEST(Refinement, KeepsAStepAndTheSurfacesOnBothSidesOfIt) {
  const auto surface = scenes::nearest({scenes::square(-0.5, 0, 1.2, 0.5), scenes::plane({0, 0, 1}, 1.3)});
  const Scene exact = scenes::makeScene(oneCamera(), surface);
  Scene scene = scenes::makeScene(oneCamera(), surface);
  scenes::addNoise(scene, 0.003f);
  const Cloud cloud = scenes::fuse(scene.rig, onePointAPixel());
  ASSERT_EQ(cloud.size(), exact.depth[0].data.size());
  double squares = 0;
  for (std::size_t k = 0; k < cloud.size(); ++k) {
    ASSERT_NEAR(cloud[k].z, exact.depth[0].data[k], 0.010f) << k;
    squares += std::pow(static_cast<double>(cloud[k].z - exact.depth[0].data[k]), 2);
  }
  EXPECT_LT(std::sqrt(squares / static_cast<double>(cloud.size())), 0.0003);
}

TEST(Refinement, HolesStayHolesAndNothingElseBecomesOne) {
  Scene scene = scenes::makeScene(oneCamera(), tiltedPlane());
  scenes::addNoise(scene, 0.004f);
  std::size_t measured = 0;
  for (std::size_t k = 0; k < scene.depth[0].data.size(); ++k) {
    if (k % 7 == 0) scene.depth[0].data[k] = 0;
    measured += scene.depth[0].data[k] > 0 ? 1 : 0;
  }
  const Cloud before = scenes::fuse(scene.rig, onePointAPixel(0)), after = scenes::fuse(scene.rig, onePointAPixel());
  ASSERT_EQ(after.size(), measured);
  ASSERT_EQ(before.size(), measured);
  for (std::size_t k = 0; k < measured; ++k) {  // on the rays of the pixels that were measured
    const Eigen::Vector3f a = before[k].getVector3fMap(), b = after[k].getVector3fMap();
    ASSERT_LT((a / a.z() - b / b.z()).norm(), 1e-5f);
  }
}

TEST(Refinement, ConfidenceAndConsistencyAreThoseOfTheMeasuredDepth) {
  Scene scene = scenes::makeScene(scenes::cameraRow(3), scenes::ballAndWall());
  scenes::addNoise(scene, 0.006f);
  FuseFlowParameters parameters;
  FrameStatistics with, without;
  scenes::fuse(scene.rig, parameters, 2, &with);
  parameters.smoothing.passes = 0;
  scenes::fuse(scene.rig, parameters, 2, &without);
  EXPECT_EQ(with.gated_points, without.gated_points);
  EXPECT_LT(with.gated_points, with.measured_points);
}

TEST(Refinement, ColoursAndImagesSmallerThanTheNeighbourhoodAreFine) {
  for (const int size : {1, 2, 3, 7}) {
    Scene scene = scenes::makeFlatScene(scenes::sameCameras(1, size, size, 40), {1.0f});
    scene.paint({10, 20, 30});
    const Cloud cloud = scenes::fuse(scene.rig, onePointAPixel());
    ASSERT_EQ(cloud.size(), static_cast<std::size_t>(size * size));
    for (const auto& point : cloud) {
      ASSERT_EQ(point.z, 1.0f);
      ASSERT_EQ(static_cast<int>(point.g), 20);
    }
  }
}

TEST(NoiseScale, IsMeasuredForEachViewAndNamedInTheStatistics) {
  const scenes::Surface wall = scenes::plane({0, 0, 1}, 2.0);  // expected noise: 0.5 + 1.425 · 4 = 6.2 mm
  Scene scene;
  const float expected = fuse_flow::axialNoise(fuse_flow::NoiseModel(), 2.0f);
  const std::vector<float> scales = {0.1f, 0.5f, 1.0f, 2.5f, 20.0f};
  scene.rig.cameras = scenes::sameCameras(static_cast<int>(scales.size()), 320, 240, 300);
  for (std::size_t i = 0; i < scales.size(); ++i) {
    Scene one = scenes::makeScene({scene.rig.cameras[i]}, wall);
    scenes::addNoise(one, scales[i] * expected, static_cast<unsigned int>(i + 1));
    scene.depth.push_back(one.depth[0]);
  }
  scene.attach();
  FrameStatistics statistics;
  scenes::fuse(scene.rig, {}, 2, &statistics);
  ASSERT_EQ(statistics.noise_scales.size(), scales.size());
  EXPECT_EQ(statistics.noise_scales[0], fuse_flow::kMinNoiseScale);
  for (std::size_t i = 1; i < 4; ++i) EXPECT_NEAR(statistics.noise_scales[i], scales[i], 0.06f * scales[i]);
  EXPECT_EQ(statistics.noise_scales[4], fuse_flow::kMaxNoiseScale);

  scene.rig.views[1] = {};
  FuseFlowParameters fixed;
  scenes::fuse(scene.rig, fixed, 2, &statistics);
  EXPECT_EQ(statistics.noise_scales[1], 1.0f);
  fixed.adapt_noise = false;
  scenes::fuse(scene.rig, fixed, 2, &statistics);
  EXPECT_EQ(statistics.noise_scales, std::vector<float>(scales.size(), 1.0f));
}

TEST(NoiseScale, ConfidenceIsRelativeToTheNoiseThatTheViewHas) {
  const scenes::Surface wall = scenes::plane({0, 0, 1}, 1.5);
  const float expected = fuse_flow::axialNoise(fuse_flow::NoiseModel(), 1.5f);
  const auto mean_confidence = [&](float sigma, bool adapt) {
    Scene scene = scenes::makeScene(oneCamera(), wall);
    scenes::addNoise(scene, sigma);
    FuseFlowParameters parameters = onePointAPixel(0);
    parameters.use_measurement_confidence = true;
    parameters.confidence.threshold = 0;
    parameters.half_weight_noise = 0;
    parameters.adapt_noise = adapt;
    double sum = 0;
    const Cloud cloud = scenes::fuse(scene.rig, parameters);
    for (const auto& point : cloud) sum += static_cast<double>(point.confidence);
    return sum / static_cast<double>(cloud.size());
  };
  const double usual = mean_confidence(expected, false);
  EXPECT_NEAR(mean_confidence(3 * expected, true), usual, 0.02);
  EXPECT_NEAR(mean_confidence(0.4f * expected, true), usual, 0.02);
  EXPECT_LT(mean_confidence(3 * expected, false), usual - 0.05);
}

TEST(NoiseWeight, MultipliesTheConfidenceAfterTheGate) {
  const Scene scene = scenes::makeFlatScene(scenes::sameCameras(1, 9, 9, 40), {2.0f});
  FuseFlowParameters parameters = onePointAPixel(0);
  parameters.confidence.noise.floor = 0.01f;
  parameters.confidence.noise.quadratic = 0.005f;  // 0.03 m at 2 m
  parameters.use_measurement_confidence = true;
  parameters.confidence.threshold = 0;
  parameters.min_support = 0;
  parameters.half_weight_noise = 0;
  const Cloud alone = scenes::fuse(scene.rig, parameters);
  parameters.half_weight_noise = 0.01f;
  const Cloud weighed = scenes::fuse(scene.rig, parameters);
  ASSERT_EQ(alone.size(), 81u);
  ASSERT_EQ(weighed.size(), 81u);
  for (std::size_t k = 0; k < 81; ++k) ASSERT_NEAR(weighed[k].confidence, alone[k].confidence / (1 + 9), 1e-6f);
  parameters.confidence.threshold = 0.4f;  // the weight is under it, C is not
  EXPECT_GT(scenes::fuse(scene.rig, parameters).size(), 40u);
}

TEST(MaxNoise, DropsMeasurementsWithMoreNoiseThanThatAsTheViewHasIt) {
  const float noise = fuse_flow::axialNoise(fuse_flow::NoiseModel(), 1.5f);
  const auto points = [&](float sigma, float max_noise) {
    Scene scene = scenes::makeScene(oneCamera(), scenes::plane({0, 0, 1}, 1.5));
    scenes::addNoise(scene, sigma);
    FuseFlowParameters parameters = onePointAPixel();
    parameters.use_measurement_confidence = true;
    parameters.confidence.threshold = 0;
    parameters.min_support = 0;
    parameters.max_noise = max_noise;
    return scenes::fuse(scene.rig, parameters).size();
  };
  const std::size_t all = 160 * 120;
  EXPECT_EQ(points(noise, 1.5f * noise), all);
  EXPECT_EQ(points(2 * noise, 1.5f * noise), 0u);
  EXPECT_EQ(points(2 * noise, 3 * noise), all);
  EXPECT_EQ(points(2 * noise, 0), all);
}

TEST(NoiseScale, AViewTwiceAsNoisyMayDisagreeTwiceAsMuch) {
  // Far enough for the noise to exceed σ: 0.5 mm + 1.425e-3 · 25 = 36 mm at 5 m, against 20 mm.
  const float noise = fuse_flow::axialNoise(fuse_flow::NoiseModel(), 5.0f);
  FuseFlowParameters parameters = onePointAPixel(0);
  parameters.use_distance_consistency = true;
  parameters.half_weight_noise = 0;
  parameters.adapt_noise = false;
  const Scene scene = scenes::makeFlatScene(scenes::sameCameras(2, 20, 15, 40), {5.0f, 5.0f + noise});
  const auto V = [&](float sigma_per_noise) {
    parameters.consistency.sigma_per_noise = sigma_per_noise;
    return scenes::fuse(scene.rig, parameters)[150].confidence;
  };
  const float twice = V(2), once = V(1);
  // Both measurements fuse: the nearer weighs exp(−d²) with the other's noise, and the other is weighed likewise.
  EXPECT_GT(twice, once + 0.2f);
  EXPECT_NEAR(twice, std::exp(-0.25f), 0.03f);
  EXPECT_NEAR(once, std::exp(-1.0f), 0.03f);
}

TEST(Refinement, ThePublishedFormHasNone) {
  const FuseFlowParameters published = FuseFlowParameters::published();
  EXPECT_EQ(published.smoothing.passes, 0);
  EXPECT_FALSE(published.adapt_noise);
  EXPECT_EQ(published.half_weight_noise, 0.0f);
  EXPECT_EQ(published.max_noise, 0.0f);
  EXPECT_EQ(published.min_support, 0);
}

}  // namespace
