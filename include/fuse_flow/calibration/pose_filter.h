#pragma once

#include <fuse_flow/calibration/extrinsic_result.h>
#include <fuse_flow/one_thread.h>
#include <fuse_flow/precompiled.h>

#include <Eigen/Geometry>

#include <cstdint>
#include <vector>

namespace fuse_flow {

/** \brief How PoseFilter tells drift from noise, and a bump from a bad frame. */
struct PoseFilterParameters {
  /** \brief How far a camera drifts from one update to the next, standard deviation, metres at the scene's radius; ≥ 0. */
  float drift{0.0001f};
  /** \brief Errors of neighbouring pixels go together: what estimates really scatter by, over what the residuals make expect;
   *  > 0. */
  float deviation_scale{5.0f};
  /** \brief What no estimate is better than, metres at the scene's radius; > 0. */
  float min_deviation{0.0005f};
  /** \brief Squared Mahalanobis distance from which on an estimate does not fit; > 0. χ² of six degrees of freedom stays under
   *  22.5 in 99.9 % of all cases. */
  float gate{22.5f};
  /** \brief So many estimates in a row that do not fit what was, but fit each other, mean that the camera has moved; ≥ 2. */
  int confirmations{3};
};

/** \brief Throws pcl::BadArgumentException naming the parameter and its value if one is out of its range. */
FUSE_FLOW_INLINE void checkParameters(const PoseFilterParameters& parameters);

/** \brief A camera that is no longer where it was. */
struct CameraMotion {
  std::size_t camera{0};                                        ///< its number
  Eigen::Isometry3d T_new_old = Eigen::Isometry3d::Identity();  ///< world frame → world frame
  double translation{0};                                        ///< of the camera's centre, metres
  double rotation{0};                                           ///< radians
};

/** \brief Poses of a rig over time: a Kalman filter for each camera, over what ExtrinsicEstimation finds frame by frame. An
 *  estimate that does not fit is kept back: it may be a bad frame. If the next ones agree with it, the camera has been moved.
 *  The frame of the world is held by the majority: if all cameras but one seem to have moved alike, that one has.
 *
 *  Only one thread at a time may use an object; a second thread gets a pcl::PCLException. Objects share nothing, so each thread may use its
 *  own object. */
class PoseFilter {
 public:
  /** \brief Starts over. \param poses of all cameras, camera → world  \param deviation of each, metres at the scene's radius;
   *  0.02 for a rig measured by hand  \throws pcl::BadArgumentException */
  FUSE_FLOW_INLINE void reset(const std::vector<Eigen::Isometry3d>& poses, double deviation);
  /** \brief \throws pcl::BadArgumentException for a value out of range */
  FUSE_FLOW_INLINE void setParameters(const PoseFilterParameters& parameters);
  /** \brief What setParameters() set, or the defaults. */
  const PoseFilterParameters& getParameters() const { return parameters_; }

  /** \brief One estimate more, which began at poses(). \returns the cameras that it confirms to have moved */
  FUSE_FLOW_INLINE std::vector<CameraMotion> update(const ExtrinsicResult& estimate);

  /** \brief Camera → world, camera by camera. */
  const std::vector<Eigen::Isometry3d>& poses() const { return poses_; }
  /** \brief Standard deviation of a pose, metres at the scene's radius. */
  FUSE_FLOW_INLINE double deviation(std::size_t camera) const;
  /** \brief Whether the last estimate of a camera was kept back. */
  bool keptBack(std::size_t camera) const { return states_[camera].odd > 0; }

 private:
  using Twist = Eigen::Matrix<double, 6, 1>;
  using Covariance = Eigen::Matrix<double, 6, 6>;
  struct State {
    Covariance P;
    int odd{0};                                                  ///< estimates in a row that did not fit
    Eigen::Isometry3d odd_pose = Eigen::Isometry3d::Identity();  ///< the last of them, camera → world
  };

  FUSE_FLOW_INLINE std::size_t reference(const std::vector<Twist>& twists, const ExtrinsicResult& estimate) const;
  FUSE_FLOW_INLINE Covariance noise(const CameraCorrection& correction) const;

  PoseFilterParameters parameters_;
  std::vector<Eigen::Isometry3d> poses_;
  detail::OneThread one_thread_;
  std::vector<State> states_;
};

}  // namespace fuse_flow

#ifndef FUSE_FLOW_DECLARATIONS_ONLY
#include <fuse_flow/impl/calibration/pose_filter.hpp>
#endif
