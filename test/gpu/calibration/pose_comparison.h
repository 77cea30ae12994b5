#pragma once

/** \file
 *  \brief The same poses searched on both devices. */

#include "../furnished_rig.h"

#include <fuse_flow/gpu/calibration/extrinsic_estimation.h>

#include <pcl/point_types.h>

#include <gtest/gtest.h>

// Compiled once, in instances.cpp.
extern template class fuse_flow::ExtrinsicEstimation<pcl::PointXYZ, fuse_flow::device::Thrust>;

namespace pose_comparison {

using furnished_rig::Poses;
using fuse_flow::ExtrinsicParameters;
using fuse_flow::ExtrinsicResult;
using HostPoses = fuse_flow::ExtrinsicEstimation<pcl::PointXYZ>;
using DevicePoses = fuse_flow::ExtrinsicEstimation<pcl::PointXYZ, fuse_flow::device::Thrust>;

/** \brief Of two orientations, radians. */
inline double turned(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return (a.linear() - b.linear()).norm() / std::sqrt(2.0);
}
inline double apart(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return (a.translation() - b.translation()).norm();
}

/** \brief Of the same search: both devices add up the same, but for where the samples' centre lies. */
inline void expectSamePoses(const ExtrinsicResult& host, const ExtrinsicResult& device) {
  ASSERT_EQ(device.T_world_camera.size(), host.T_world_camera.size());
  EXPECT_EQ(device.iterations, host.iterations);
  EXPECT_EQ(device.converged, host.converged);
  EXPECT_NEAR(device.residual_before, host.residual_before, 1e-7);
  EXPECT_NEAR(device.residual, host.residual, 1e-7);
  EXPECT_LT((device.scene_center - host.scene_center).norm(), 1e-9);
  EXPECT_NEAR(device.scene_radius, host.scene_radius, 1e-9);
  for (std::size_t i = 0; i < host.T_world_camera.size(); ++i) {
    EXPECT_LT(apart(device.T_world_camera[i], host.T_world_camera[i]), 2e-6) << i;
    EXPECT_LT(turned(device.T_world_camera[i], host.T_world_camera[i]), 2e-6) << i;
    const fuse_flow::CameraCorrection &a = host.corrections[i], &b = device.corrections[i];
    EXPECT_EQ(b.neighbours, a.neighbours) << i;
    EXPECT_EQ(b.constrained, a.constrained) << i;
    EXPECT_EQ(b.free_directions.size(), a.free_directions.size()) << i;
    EXPECT_NEAR(b.translation_deviation, a.translation_deviation, 0.01 * a.translation_deviation + 1e-9) << i;
    EXPECT_NEAR(b.rotation_deviation, a.rotation_deviation, 0.01 * a.rotation_deviation + 1e-9) << i;
  }
  ASSERT_EQ(device.overlaps.size(), host.overlaps.size());
  for (std::size_t k = 0; k < host.overlaps.size(); ++k) {
    EXPECT_EQ(device.overlaps[k].first, host.overlaps[k].first);
    EXPECT_EQ(device.overlaps[k].second, host.overlaps[k].second);
    EXPECT_NEAR(static_cast<double>(device.overlaps[k].correspondences),
                static_cast<double>(host.overlaps[k].correspondences), 3);
  }
}

inline bool samePoses(const ExtrinsicResult& a, const ExtrinsicResult& b) {
  if (a.T_world_camera.size() != b.T_world_camera.size() || a.iterations != b.iterations || a.residual != b.residual)
    return false;
  for (std::size_t i = 0; i < a.T_world_camera.size(); ++i)
    if (a.T_world_camera[i].matrix() != b.T_world_camera[i].matrix() ||
        a.corrections[i].covariance != b.corrections[i].covariance)
      return false;
  return true;
}

/** \brief One frame, estimated on both. */
inline void expectSamePoses(const fuse_flow::RigFrame& frame, const Poses& initial,
                            const ExtrinsicParameters& parameters, HostPoses& host, DevicePoses& device) {
  host.setParameters(parameters);
  device.setParameters(parameters);
  host.clear();
  device.clear();
  host.addFrame(frame);
  device.addFrame(frame);
  expectSamePoses(host.estimate(initial), device.estimate(initial));
}

}  // namespace pose_comparison
