#include <fuse_flow/fuse_flow.h>

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace {

using namespace fuse_flow;

constexpr float kPixelAngle = 1.0f / 525.0f;

ConfidenceParameters published() {
  ConfidenceParameters p;
  p.form = ConfidenceForm::Published;
  return p;
}

float slopeCompensated(const ConfidenceParameters& p, const DepthPatch& patch) {
  return confidenceSlopeCompensated(p, patch, slopeScale(p, kPixelAngle, viewNoise(p, nullptr)));
}

/** \brief α / (1 + βG) + γ / (1 + δσ), as the paper writes it, over α + γ. */
double byHand(double G, double sigma) { return (0.5 / (1 + 0.5 * G) + 1.0 / (1 + sigma)) / 1.5; }

DepthPatch constant(float z) { return {{z, z, z, z, z, z, z, z, z}}; }

/** \brief What a camera sees of a plane through (0, 0, z) whose normal leans by angle towards azimuth. */
DepthPatch tilted(double z, double angle, double azimuth) {
  DepthPatch patch{};
  for (int i = 0; i < 9; ++i) {
    const double x = (i % 3 - 1) * static_cast<double>(kPixelAngle);
    const double y = (i / 3 - 1) * static_cast<double>(kPixelAngle);
    const double along = x * std::cos(azimuth) + y * std::sin(azimuth);
    patch.z[i] = static_cast<float>(z / (1 + std::tan(angle) * along));
  }
  return patch;
}

TEST(Confidence, IsOneWithoutGradientAndSpread) { EXPECT_FLOAT_EQ(confidence({}, 0, 0), 1.0f); }

TEST(Confidence, FollowsEquationThreeByHand) {
  // α = β = 0.5, γ = δ = 1: (0.5/2 + 1/2) / 1.5 and (0.5 + 1/4) / 1.5.
  EXPECT_FLOAT_EQ(confidence({}, 2, 1), 0.5f);
  EXPECT_FLOAT_EQ(confidence({}, 0, 3), 0.5f);
  ConfidenceParameters p;
  p.alpha = 2;
  p.beta = 1;
  p.gamma = 0;
  EXPECT_FLOAT_EQ(confidence(p, 3, 100), 0.25f);
}

TEST(Gate, AsksForConfidenceOnlyWhereNoiseIsMoreThanGateNoise) {
  const auto weight = [](float C, float noise, float gate_noise, float max_noise = 0, float scale = 1) {
    return measurementGate(0.6f, gate_noise, max_noise, 0, ViewNoise{{noise, 0, 0}, scale, 1}).weight(C, 2);
  };
  EXPECT_EQ(weight(0.7f, 0.03f, 0.02f), 0.7f);
  EXPECT_EQ(weight(0.3f, 0.03f, 0.02f), 0.0f);
  EXPECT_EQ(weight(0.3f, 0.02f, 0.02f), 0.3f) << "as much is not more";
  EXPECT_EQ(weight(0.3f, 0.01f, 0.02f), 0.3f);
  EXPECT_EQ(weight(0.3f, 0.01f, 0), 0.0f) << "0: everywhere";
  EXPECT_EQ(weight(0.3f, 0, 0), 0.0f) << "of exact measurements, too";
  EXPECT_EQ(weight(0, 0.01f, 0.02f), 0.0f) << "what has no confidence never passes";
  EXPECT_EQ(weight(0.3f, 0.01f, 0.02f, 0, 2.5f), 0.0f) << "the noise that the view has: 25 mm";
  EXPECT_EQ(weight(0.3f, 0.03f, 0.02f, 0, 0.5f), 0.3f) << "15 mm";
  EXPECT_EQ(weight(0.3f, 0.01f, 0.02f, 0.005f), 0.0f) << "max_noise is asked as well";
}

TEST(Confidence, PublishedThresholdIsThePapersOnTheNormalisedScale) {
  // α / (1 + βG) + γ / (1 + δσ) = 0.5/5 + 1/2 = 0.6 is the paper's τ.
  const float threshold = fuse_flow::FuseFlowParameters::published().confidence.threshold;
  EXPECT_NEAR(confidence({}, 8, 1), threshold, 1e-6f);
  EXPECT_LT(confidence({}, 8.1f, 1), threshold);
  EXPECT_GT(confidence({}, 7.9f, 1), threshold);
}

TEST(Confidence, APixelAloneDoesNotPassTheDefaultGate) {
  fuse_flow::DepthPatch alone{};
  alone.z[4] = 1.0f;
  EXPECT_LT(slopeCompensated({}, alone), ConfidenceParameters{}.threshold);
}

TEST(Confidence, FallsWithGradientAndWithSpread) {
  for (int k = 0; k < 20; ++k) {
    const float x = 0.3f * static_cast<float>(k);
    EXPECT_GT(confidence({}, x, 1), confidence({}, x + 0.3f, 1));
    EXPECT_GT(confidence({}, 1, x), confidence({}, 1, x + 0.3f));
  }
}

TEST(ConfidencePublished, IsOneAtConstantDepth) {
  for (const float z : {0.5f, 1.0f, 7.25f}) EXPECT_FLOAT_EQ(confidencePublished(published(), constant(z)), 1.0f);
}

TEST(ConfidencePublished, OfAStepBesideThePixelIsByHand) {
  // One column 2 cm behind: G = 1 cm; of nine, three differ by 2 cm: σ² = 12/9 − (6/9)² = 8/9.
  const DepthPatch patch{{1, 1, 1.02f, 1, 1, 1.02f, 1, 1, 1.02f}};
  EXPECT_NEAR(confidencePublished(published(), patch), byHand(1.0, std::sqrt(8.0 / 9.0)), 1e-4);
}

TEST(ConfidencePublished, OfASpreadWithoutGradientIsByHand) {
  // The centre 3 cm behind eight others: G = 0, σ² = 9/9 − (3/9)² = 8/9.
  const DepthPatch patch{{1, 1, 1, 1, 1.03f, 1, 1, 1, 1}};
  EXPECT_NEAR(confidencePublished(published(), patch), byHand(0.0, std::sqrt(8.0 / 9.0)), 1e-4);
}

TEST(ConfidencePublished, OfARampAlongBothAxesIsByHand) {
  // 3 cm a column, 4 cm a row: G = 5 cm; σ² = (2/3) (9 + 16).
  const DepthPatch patch{{1.00f, 1.03f, 1.06f, 1.04f, 1.07f, 1.10f, 1.08f, 1.11f, 1.14f}};
  EXPECT_NEAR(confidencePublished(published(), patch), byHand(5.0, std::sqrt(50.0 / 3.0)), 1e-4);
}

TEST(ConfidencePublished, DifferencesAreOneSidedBesideAHole) {
  // The left column is missing: G = 2 cm; of six, three differ by 2 cm: σ² = 12/6 − (6/6)² = 1.
  const DepthPatch patch{{0, 1, 1.02f, 0, 1, 1.02f, 0, 1, 1.02f}};
  EXPECT_NEAR(confidencePublished(published(), patch), byHand(2.0, 1.0), 1e-4);
}

TEST(ConfidencePublished, MetresWithACentimetreAsUnitAreCentimetresWithUnitOne) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> depth(0.9f, 1.1f);
  ConfidenceParameters centimetres = published();
  centimetres.length_unit = 1.0f;
  ASSERT_FLOAT_EQ(published().length_unit, 0.01f);
  for (int k = 0; k < 100; ++k) {
    DepthPatch m{}, cm{};
    for (int i = 0; i < 9; ++i) {
      m.z[i] = depth(random);
      cm.z[i] = 100.0f * m.z[i];
    }
    EXPECT_NEAR(confidencePublished(published(), m), confidencePublished(centimetres, cm), 1e-5f);
  }
}

TEST(ConfidencePublished, ASmallerUnitMakesTheSamePatchWorse) {
  const DepthPatch patch{{1, 1, 1.02f, 1, 1, 1.02f, 1, 1, 1.02f}};
  ConfidenceParameters metres = published(), millimetres = published();
  metres.length_unit = 1.0f;
  millimetres.length_unit = 0.001f;
  EXPECT_GT(confidencePublished(metres, patch), 0.98f);
  EXPECT_NEAR(confidencePublished(millimetres, patch), byHand(10.0, 10 * std::sqrt(8.0 / 9.0)), 1e-3);
}

TEST(ConfidenceForms, StayWithinZeroAndOneWhateverThePatch) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> depth(0.1f, 20.0f);
  std::bernoulli_distribution hole(0.3);
  for (int k = 0; k < 2000; ++k) {
    DepthPatch patch{};
    for (float& z : patch.z) z = hole(random) ? 0.0f : depth(random);
    patch.z[4] = depth(random);
    for (const float C : {confidencePublished(published(), patch), slopeCompensated({}, patch)}) {
      ASSERT_GT(C, 0.0f);
      ASSERT_LE(C, 1.0f);
    }
  }
}

TEST(ConfidenceSlopeCompensated, IsOneAtConstantDepth) {
  for (const float z : {0.5f, 1.0f, 7.25f}) EXPECT_FLOAT_EQ(slopeCompensated({}, constant(z)), 1.0f);
}

TEST(ConfidenceSlopeCompensated, APlaneTiltedByUpToSixtyDegreesKeepsItsConfidence) {
  for (const double z : {0.7, 1.5, 3.0, 5.0})
    for (const double degrees : {0.0, 15.0, 30.0, 45.0, 60.0})
      for (const double azimuth : {0.0, 0.4, 0.785398, 1.570796, 2.5})
        EXPECT_GT(slopeCompensated({}, tilted(z, degrees * M_PI / 180, azimuth)), 0.97f)
            << degrees << " degrees at " << z << " m towards " << azimuth;
}

TEST(ConfidencePublished, APlaneTiltedBySixtyDegreesLosesItsConfidence) {
  // 4 m · tan 60° / 525 = 1.32 cm a pixel: G = 1.32, σ = 1.32 · √(2/3) = 1.08.
  EXPECT_NEAR(confidencePublished(published(), tilted(4.0, M_PI / 3, 0.0)), byHand(1.32, 1.078), 5e-3);
}

TEST(ConfidenceSlopeCompensated, ADepthJumpHasLowConfidence) {
  EXPECT_LT(slopeCompensated({}, {{1, 1, 1.5f, 1, 1, 1.5f, 1, 1, 1.5f}}), 0.2f);
  EXPECT_LT(slopeCompensated({}, {{1.5f, 1.5f, 1.5f, 1, 1, 1, 1, 1, 1}}), 0.2f);
  EXPECT_LT(slopeCompensated({}, {{1, 1, 1, 1, 1, 1.5f, 1, 1.5f, 1.5f}}), 0.2f);
}

TEST(ConfidenceSlopeCompensated, APixelThatStandsOutOfItsNeighboursHasLowConfidence) {
  EXPECT_LT(slopeCompensated({}, {{1, 1, 1, 1, 1.5f, 1, 1, 1, 1}}), 0.4f);
  EXPECT_LT(slopeCompensated({}, {{1, 1, 1, 1, 0.5f, 1, 1, 1, 1}}), 0.4f);
}

TEST(ConfidenceSlopeCompensated, ADirectionWithAMissingNeighbourCountsAQuarterOfAUnit) {
  DepthPatch patch = constant(1);
  patch.z[3] = 0;
  EXPECT_NEAR(slopeCompensated({}, patch), byHand(0.25, 0.25), 1e-5);
  patch.z[5] = 0;  // the same direction
  EXPECT_NEAR(slopeCompensated({}, patch), byHand(0.25, 0.25), 1e-5);
  patch.z[0] = 0;
  EXPECT_NEAR(slopeCompensated({}, patch), byHand(0.5, 0.5), 1e-5);
}

TEST(ConfidenceSlopeCompensated, APixelWithoutNeighboursCountsAWholeUnit) {
  DepthPatch patch{};
  patch.z[4] = 1;
  EXPECT_NEAR(slopeCompensated({}, patch), byHand(1, 1), 1e-5);  // 5/9, much under the 1 of a wall
}

TEST(ConfidenceSlopeCompensated, SpreadIsThatOfTheSecondDifferencesByHand) {
  // The centre 1 cm behind: r = −2 cm in all four directions, σ² = 4/6 cm² at the reference depth, where noise scales by one.
  const DepthPatch patch{{1, 1, 1, 1, 1.01f, 1, 1, 1, 1}};
  ConfidenceParameters p;
  p.noise.quadratic = 0;  // the same noise at every depth
  EXPECT_NEAR(slopeCompensated(p, patch), byHand(0, std::sqrt(4.0 / 6.0)), 1e-4);
}

TEST(ConfidenceSlopeCompensated, NoiseIsJudgedByWhatTheSensorHasAtThatDepth) {
  ConfidenceParameters p;
  p.noise.floor = 0;
  p.noise.quadratic = 0.002f;
  // 5 mm at 1 m are as bad as 20 mm at 2 m, where the noise is four times as large.
  DepthPatch near = constant(1), far = constant(2);
  near.z[0] += 0.005f;
  far.z[0] += 0.02f;
  EXPECT_NEAR(slopeCompensated(p, near), slopeCompensated(p, far), 1e-3f);
  EXPECT_FLOAT_EQ(axialNoise(p.noise, 2), 0.008f);
}

}  // namespace
