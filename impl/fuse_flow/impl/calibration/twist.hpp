#pragma once

#include <Eigen/Geometry>
#include <Eigen/SVD>

#include <cstddef>
#include <vector>

namespace fuse_flow {
namespace host {

// A small rigid motion about the scene's centre as six numbers of one unit: translation of the centre, metres, and rotation times
// the scene's radius.

/** \brief \param T world → world  \param center metres  \param radius metres */
inline Eigen::Matrix<double, 6, 1> toTwist(const Eigen::Isometry3d& T, const Eigen::Vector3d& center, double radius) {
  const Eigen::AngleAxisd rotation(T.linear());
  Eigen::Matrix<double, 6, 1> twist;
  twist << T * center - center, radius * rotation.angle() * rotation.axis();
  return twist;
}

/** \brief Inverse of toTwist(). */
inline Eigen::Isometry3d toMotion(const Eigen::Matrix<double, 6, 1>& twist, const Eigen::Vector3d& center,
                                  double radius) {
  const Eigen::Vector3d rotation = twist.tail<3>() / radius;
  const double angle = rotation.norm();
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  if (angle > 0) motion.linear() = Eigen::AngleAxisd(angle, rotation / angle).toRotationMatrix();
  motion.translation() = center + twist.head<3>() - motion.linear() * center;
  return motion;
}

/** \brief The rotation nearest to a matrix that is about one, or a sum of some that differ little. */
inline Eigen::Matrix3d nearestRotation(const Eigen::Matrix3d& M) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

/** \brief The motion that several are on average: the rotation nearest to the mean of theirs, and the mean of their
 *  translations. \param motions one at least */
inline Eigen::Isometry3d meanMotion(const std::vector<Eigen::Isometry3d>& motions) {
  Eigen::Matrix3d rotations = Eigen::Matrix3d::Zero();
  Eigen::Vector3d translations = Eigen::Vector3d::Zero();
  for (const Eigen::Isometry3d& motion : motions) {
    rotations += motion.linear();
    translations += motion.translation();
  }
  Eigen::Isometry3d mean = Eigen::Isometry3d::Identity();
  mean.linear() = nearestRotation(rotations);
  mean.translation() = translations / static_cast<double>(motions.size());
  return mean;
}

/** \brief Lays poses onto where they were, on average: the gauge Gauge::Mean. \param group cameras that move as one; one at least
 *  \param motion motion(i): by what camera i has moved  \param poses of all cameras */
template <typename Motion>
void takeMeanMotionAway(const std::vector<std::size_t>& group, const Motion& motion,
                        std::vector<Eigen::Isometry3d>& poses) {
  std::vector<Eigen::Isometry3d> motions;
  for (const std::size_t i : group) motions.push_back(motion(i));
  const Eigen::Isometry3d back = meanMotion(motions).inverse();
  for (const std::size_t i : group) poses[i] = back * poses[i];
}

}  // namespace host
}  // namespace fuse_flow
