#include <fuse_flow/impl/host/pose_graph.hpp>

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
      addCorrespondence(color, vector(), vector(), 0.01f * normal(random), 0.1f);
    }
    graph.addGeometry(i, i + 1, geometry, 0.3);
    graph.addColor(i, i + 1, color, 0.7);
  }
  return graph;
}

/** \brief What PoseUncertainty makes of the motions that are told, with scores that scatter as the graph's curvature does. */
Eigen::MatrixXd covariance(const PoseGraph& graph) {
  const CholeskyFactors J(graph.sensitivity());
  const Eigen::MatrixXd C = J.solveColumns(J.solveColumns(graph.curvature()).transpose());
  return product(graph.told(), product(C, Eigen::MatrixXd(graph.told().transpose())));
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
    ASSERT_TRUE(twists.told().isIdentity(0));
    ASSERT_FALSE(modes.told().isIdentity(0.1));
    const Eigen::MatrixXd expected = covariance(modes);
    EXPECT_TRUE(covariance(twists).isApprox(expected, 1e-9)) << covariance(twists) << "\n\n" << expected;
    // Noise counts: with none taken off, covariances would be smaller by far more than that.
    PoseGraph doubtless = chain();
    doubtless.decompose(2, color);
    doubtless.findModes();
    const CholeskyFactors all(doubtless.curvature());
    EXPECT_GT((all.solveColumns(Eigen::MatrixXd::Identity(12, 12)) - expected).norm(), 0.02 * expected.norm());
    const Eigen::VectorXd g = Eigen::VectorXd::LinSpaced(12, -1, 1), c = Eigen::VectorXd::LinSpaced(12, 2, 1);
    EXPECT_TRUE(modes.scores(g, c).isApprox(transposedProduct(modes.told(), twists.scores(g, c)), 1e-9));
    EXPECT_TRUE(twists.step().isApprox(modes.step(), 1e-9));
  }
}

}  // namespace
