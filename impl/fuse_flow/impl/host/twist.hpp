#pragma once

#include <Eigen/Geometry>

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

}  // namespace host
}  // namespace fuse_flow
