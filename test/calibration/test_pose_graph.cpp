#include <fuse_flow/impl/calibration/pose_graph.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace {

using namespace fuse_flow;
using namespace fuse_flow::host;

/** \brief Three cameras in a chain, whose correspondences look in all directions. */
PoseGraph chain() {
  std::mt19937 random(3);
  std::normal_distribution<float> normal;
  const auto vector = [&] { return Vec3{normal(random), normal(random), normal(random)}; };
  PoseGraph graph(3);
  for (std::size_t i = 0; i < 2; ++i) {
    AlignmentSums geometry{}, color{};
    for (int k = 0; k < 200; ++k) {
      const Vec3 n = vector();
      addCorrespondence(geometry, vector(), (1.0f / std::sqrt(squaredNorm(n))) * n, 0.01f * normal(random), 1.0f);
      const Vec3 gradient = vector();
      addCorrespondence(color, vector(), gradient, gradient, 0.01f * normal(random), 0.1f);
    }
    graph.addGeometry(i, i + 1, geometry, 0.3);
    graph.addColor(i, i + 1, color, 0.7);
  }
  return graph;
}

/** \brief What PoseUncertainty makes of the observable motions, with scores that scatter as the graph's curvature does. */
Eigen::MatrixXd covariance(const PoseGraph& graph) {
  const CholeskyFactors J(graph.sensitivity());
  const Eigen::MatrixXd C = J.solveColumns(J.solveColumns(graph.curvature()).transpose());
  return product(graph.observable(), product(C, Eigen::MatrixXd(graph.observable().transpose())));
}

TEST(PoseGraph, WhereAllIsToldTheTwistsAreAsGoodAsTheModes) {
  for (const std::optional<ColorRole>& color :
       {std::optional<ColorRole>{}, std::optional<ColorRole>(ColorRole{100, 1e-3})}) {
    PoseGraph twists = chain(), modes = chain();
    twists.decompose(2, color);
    modes.decompose(1, color);  // so little is asked that noise may take less than S off: that needs modes
    twists.findModes();
    modes.findModes();
    ASSERT_EQ(twists.freeMotions(), 0);
    ASSERT_EQ(modes.freeMotions(), 0);
    ASSERT_TRUE(twists.observable().isIdentity(0));
    ASSERT_FALSE(modes.observable().isIdentity(0.1));
    const Eigen::MatrixXd expected = covariance(modes);
    EXPECT_TRUE(covariance(twists).isApprox(expected, 1e-9)) << covariance(twists) << "\n\n" << expected;
    // Noise counts: with none taken off, covariances would be smaller by far more than that.
    PoseGraph doubtless = chain();
    doubtless.decompose(2, color);
    doubtless.findModes();
    const CholeskyFactors all(doubtless.curvature());
    EXPECT_GT((all.solveColumns(Eigen::MatrixXd::Identity(12, 12)) - expected).norm(), 0.02 * expected.norm());
    const Eigen::VectorXd g = Eigen::VectorXd::LinSpaced(12, -1, 1), c = Eigen::VectorXd::LinSpaced(12, 2, 1);
    EXPECT_TRUE(modes.scores(g, c).isApprox(transposedProduct(modes.observable(), twists.scores(g, c)), 1e-9));
    EXPECT_TRUE(twists.step().isApprox(modes.step(), 1e-9));
  }
}

PoseGraph ofTwoCameras(const AlignmentSums& geometry, double normal_noise, const AlignmentSums& color) {
  PoseGraph graph(2);
  graph.addGeometry(0, 1, geometry, normal_noise);
  graph.addColor(0, 1, color, 1);
  graph.decompose(2, ColorRole{100, 1e-3});
  graph.findModes();
  return graph;
}

/** \brief Two cameras that see a floor. Depth determines its height and tilt; grey levels change along x.
 *  \param share of the gradient that both images show */
PoseGraph floorOf(float share) {
  std::mt19937 random(5);
  std::normal_distribution<float> normal;
  AlignmentSums geometry{}, color{};
  for (int k = 0; k < 400; ++k) {
    const Vec3 x{normal(random), normal(random), 0};
    Vec3 n{0.01f * normal(random), 0.01f * normal(random), 1};
    addCorrespondence(geometry, x, (1.0f / std::sqrt(squaredNorm(n))) * n, 0, 1e6f);
    const float of_both = std::sqrt(share) * normal(random), of_one = std::sqrt(1 - share) * normal(random),
                of_other = std::sqrt(1 - share) * normal(random);
    addCorrespondence(color, x, {of_both + of_one, 0, 0}, {of_both + of_other, 0, 0}, 0, 1e6f);
  }
  return ofTwoCameras(geometry, 0.0141, color);
}

TEST(PoseGraph, ColourTellsWhatBothImagesShow) {
  EXPECT_EQ(floorOf(1).freeMotions(), 3) << "of geometry: two slides and a turn";
  const auto open = [](float share) { return floorOf(share).freeDirections(1).size(); };
  EXPECT_EQ(open(1), 1u) << "the slide along y: gradients along x tell that along x, and the turn";
  EXPECT_EQ(open(0.25f), 1u);
  EXPECT_EQ(open(0), 3u) << "noise";
}

TEST(PoseGraph, WhatColourTellsIsAsSureAsBothImagesShowIt) {
  const auto deviation = [](float share) { return std::sqrt(covariance(floorOf(share))(0, 0)); };
  EXPECT_NEAR(deviation(0.5f) / deviation(1), 2, 0.3);
  EXPECT_NEAR(deviation(0.25f) / deviation(1), 4, 0.8);
}

/** \brief Two cameras whose geometry determines all directions, and colour of the given weight. \param shared whether both images show the
 *  gradients */
PoseGraph toldByBoth(float weight, bool shared) {
  std::mt19937 random(8);
  std::normal_distribution<float> normal;
  const auto vector = [&] { return Vec3{normal(random), normal(random), normal(random)}; };
  AlignmentSums geometry{}, color{};
  for (int k = 0; k < 1000; ++k) {
    const Vec3 n = vector();
    addCorrespondence(geometry, vector(), (1.0f / std::sqrt(squaredNorm(n))) * n, 0, 1);
    const Vec3 gradient = vector(), other = vector();
    addCorrespondence(color, vector(), gradient, shared ? gradient : other, 0, weight);
  }
  return ofTwoCameras(geometry, 0.1, color);
}

TEST(PoseGraph, OfWhatColourAddsToGeometryOnlyWhatBothImagesShowCounts) {
  const Eigen::MatrixXd none = toldByBoth(0, true).sensitivity();
  const PoseGraph shared = toldByBoth(0.3f, true), unshared = toldByBoth(0.3f, false);
  const Eigen::MatrixXd color = shared.curvature() - toldByBoth(0, true).curvature();
  ASSERT_GT(color.norm(), 0.3 * none.norm());
  EXPECT_LT((shared.sensitivity() - none - color).norm(), 1e-9 * none.norm());
  EXPECT_LT((unshared.sensitivity() - none).norm(), 0.1 * color.norm());
}

// Products of noise are about zero, but of much of it more than all that geometry tells, to either side.
TEST(PoseGraph, MuchNoiseOfColourTakesNothingFromGeometry) {
  const Eigen::MatrixXd none = toldByBoth(0, true).sensitivity(), much = toldByBoth(1e3f, false).sensitivity();
  const SymmetricEigen more(Eigen::MatrixXd(much - none));
  EXPECT_GT(more.values[0], -1e-6 * much.norm());
  EXPECT_LT(more.values[5], 0.2 * toldByBoth(1e3f, true).sensitivity().norm());
}

// As brightness that two images do not share: each may be brighter than the other as a whole.
TEST(ColorInformation, AGradientThatIsTheSameEverywhereTellsNothing) {
  std::mt19937 random(6);
  std::normal_distribution<float> normal;
  AlignmentSums even{}, uneven{};
  for (int k = 0; k < 400; ++k) {
    const float w = 0.5f + 0.5f * std::abs(normal(random)), at = normal(random);
    addCorrespondence(even, {}, {3, 1, 0}, {3, 1, 0}, 0.2f + 0.1f * normal(random), w);
    addCorrespondence(uneven, {}, {3 + at, 1, 0}, {3 + at, 1, 0}, 5 + 0.1f * at, w);
  }
  const ColorInformation of_even(even), of_uneven(uneven);
  EXPECT_LT(of_even.all.norm(), 1e-9 * symmetric6(even.A).norm());
  EXPECT_LT(of_even.shared.norm(), 1e-9 * symmetric6(even.A).norm());
  EXPECT_LT(of_even.g.norm(), 1e-4 * Vector6d(even.g).norm());
  Matrix6d expected = Matrix6d::Zero();
  expected(0, 0) = uneven.w;
  EXPECT_LT((of_uneven.all - expected).norm(), 0.2 * uneven.w);
  EXPECT_LT((of_uneven.shared - expected).norm(), 0.2 * uneven.w);
  EXPECT_NEAR(of_uneven.g[0] / of_uneven.all(0, 0), 0.1, 1e-5) << "brighter by 5 makes no difference";
  EXPECT_EQ(ColorInformation(AlignmentSums{}).all, Matrix6d::Zero());
}

TEST(PoseGraph, WhatIsFreeIsTakenOutAndNothingElse) {
  const PoseGraph graph = floorOf(1);
  Vector6d slide = Vector6d::Zero(), lift = Vector6d::Zero();
  slide[1] = 0.03;
  lift[2] = 0.02;
  lift[3] = 0.01;
  EXPECT_LT(graph.withoutFree(slide).norm(), 0.02 * slide.norm());
  EXPECT_LT((graph.withoutFree(lift) - lift).norm(), 0.02 * lift.norm());
  EXPECT_LT((graph.withoutFree(slide + lift) - lift).norm(), 0.02 * lift.norm());
  Vector6d across = Vector6d::Zero();
  across[0] = 0.03;
  EXPECT_LT((graph.withoutFree(across) - across).norm(), 0.1 * across.norm()) << "colour tells this one";
}

}  // namespace
