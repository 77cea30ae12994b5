#pragma once

#include <fuse_flow/impl/calibration/pose_graph.hpp>
#include <fuse_flow/impl/calibration/rig_correspondences.hpp>

#include <map>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief How far the poses of a rig may be from the true ones, along what is observable.
 *
 *  Residuals are not independent: neighbouring pixels share noise, and at occlusions all correspondences err to one side. So the images are
 *  divided into parts c. Each part has its own gradient g_c. Where the poses have converged, Σ g_c = 0, and the scatter of the g_c shows
 *  how well the parts agree. With J the change of Σ g_c along the motions, noise of the normals aside, the covariance is J⁻¹ (Σ g_c g_cᵀ)
 *  J⁻ᵀ, the sandwich of Huber (1967) and White (1980), clustered after Liang and Zeger (1986). */
class PoseUncertainty {
 public:
  /** \param graph decomposed at the poses at which system was evaluated  \param fewest correspondences of a pair that counts
   *  \param scale standard deviation of the residuals, over what noise makes expect */
  PoseUncertainty(const PoseGraph& graph, RigCorrespondences& system, double fewest, double scale)
      : observable_(graph.observable()) {
    const Eigen::Index n = observable_.cols();
    if (n == 0) return;
    std::map<std::pair<std::size_t, std::size_t>, std::pair<Eigen::VectorXd, Eigen::VectorXd>> parts;
    for (const AlignmentCluster& cluster : system.clusters()) {
      auto& [geometry, color] = parts[{cluster.camera, cluster.part}];
      if (geometry.size() == 0) geometry = color = Eigen::VectorXd::Zero(graph.size());
      for (std::size_t slot = 0; slot < cluster.geometry.size(); ++slot) {
        const PairSums& pair = system.pairs()[system.firstPair(cluster.camera) + slot];
        if (pair.geometry.count < fewest) continue;
        PoseGraph::addGradient(geometry, pair.i, pair.j, Vector6d(cluster.geometry[slot].g));
        PoseGraph::addGradient(color, pair.i, pair.j, pair.color_trust * colorGradient(pair, cluster.color[slot]));
      }
    }
    Eigen::MatrixXd scatter = scale * scale * graph.curvature();
    Eigen::VectorXd mean = Eigen::VectorXd::Zero(n);
    const double count = static_cast<double>(parts.size());
    std::vector<Eigen::VectorXd> scores;
    for (const auto& [key, gradients] : parts) scores.push_back(graph.scores(gradients.first, gradients.second));
    for (const Eigen::VectorXd& score : scores) mean += score / count;
    for (const Eigen::VectorXd& score : scores) {
      const Eigen::VectorXd difference = score - mean;
      scatter.noalias() += difference * difference.transpose();
    }
    const CholeskyFactors J(graph.sensitivity());
    covariance_ = J.solveColumns(J.solveColumns(scatter).transpose());
  }

  /** \brief Of a camera's twist relative to camera 0. */
  Matrix6d covariance(std::size_t camera) const {
    if (camera == 0 || observable_.cols() == 0) return Matrix6d::Zero();
    const Eigen::MatrixXd part = observable_.middleRows(PoseGraph::begin(camera), 6).transpose();
    const Matrix6d covariance = transposedProduct(part, product(covariance_, part));
    return 0.5 * (covariance + covariance.transpose());
  }

 private:
  /** \brief With the pair's mean gradient off, as ColorInformation::g: what one image is brighter as a whole pulls no pose. */
  static Vector6d colorGradient(const PairSums& pair, const AlignmentSums& part) {
    const ColorInformation whole(pair.color);
    return Vector6d(part.g) - part.wr * whole.mean;
  }

  Eigen::MatrixXd observable_;
  Eigen::MatrixXd covariance_;
};

}  // namespace host
}  // namespace fuse_flow
