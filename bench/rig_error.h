#pragma once

/** \file
 *  \brief How far the poses of a rig are from the true ones. */

#include <Eigen/Geometry>
#include <Eigen/SVD>

#include <cstddef>
#include <vector>

namespace bench {

/** \brief Of one camera, after the rig as a whole was laid onto the true one: where the rig stands in the world is not asked. */
struct PoseError {
  double mm{0};
  double degrees{0};
};

inline std::vector<PoseError> rigError(const std::vector<Eigen::Isometry3d>& found,
                                       const std::vector<Eigen::Isometry3d>& truth) {
  Eigen::Matrix3d rotations = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < found.size(); ++i) rotations += truth[i].linear() * found[i].linear().transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(rotations, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d R = svd.matrixU() * svd.matrixV().transpose();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < found.size(); ++i) t += truth[i].translation() - R * found[i].translation();
  t /= static_cast<double>(found.size());
  std::vector<PoseError> errors;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Eigen::Matrix3d turn = R * found[i].linear() * truth[i].linear().transpose();
    errors.push_back({1000 * (R * found[i].translation() + t - truth[i].translation()).norm(),
                      57.29577951308232 * Eigen::AngleAxisd(turn).angle()});
  }
  return errors;
}

}  // namespace bench
