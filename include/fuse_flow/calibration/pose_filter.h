#pragma once

#include <fuse_flow/calibration/extrinsic_result.h>
#include <fuse_flow/one_thread.h>
#include <fuse_flow/precompiled.h>

#include <Eigen/Geometry>

#include <cstdint>
#include <vector>

namespace fuse_flow {

/** \brief How PoseFilter distinguishes drift from noise, and a bump from a bad frame. */
struct PoseFilterParameters {
  /** \brief Standard deviation of the drift of a camera from one update to the next, metres at the scene's radius; ≥ 0. */
  float drift{0.0001f};
  /** \brief Scatter of the estimates divided by the scatter that the residuals predict; > 0. It is more than 1, because neighbouring pixels
   *  share errors. */
  float deviation_scale{5.0f};
  /** \brief Smallest standard deviation of an estimate, metres at the scene's radius; > 0. */
  float min_deviation{0.0005f};
  /** \brief Squared Mahalanobis distance above which an estimate does not fit; > 0. χ² of six degrees of freedom stays under
   *  22.5 in 99.9 % of all cases. */
  float gate{22.5f};
  /** \brief If this many estimates in a row do not fit the old pose, but fit each other, the camera has moved; ≥ 2. */
  int confirmations{3};
};

/** \brief Throws pcl::BadArgumentException naming the parameter and its value if one is out of its range. */
FUSE_FLOW_INLINE void checkParameters(const PoseFilterParameters& parameters);

/** \brief A camera that has moved. */
struct CameraMotion {
  std::size_t camera{0};                                        ///< its number
  Eigen::Isometry3d T_new_old = Eigen::Isometry3d::Identity();  ///< world frame → world frame
  double translation{0};                                        ///< of the camera's centre, metres
  double rotation{0};                                           ///< radians
};

/** \brief Filters the poses of a rig over time: a Kalman filter for each camera, whose inputs are the results of ExtrinsicEstimation for
 *  each frame. An estimate that does not fit is held back, because the frame may be bad. If the next estimates agree with it, the camera
 *  has moved. The majority of the cameras defines the world frame: if all cameras but one seem to have moved in the same way, that one
 *  camera has moved.
 *
 *  Only one thread at a time may use an object; a second thread gets a pcl::PCLException. Objects share nothing, so each thread may use its
 *  own object. */
class PoseFilter {
 public:
  /** \brief Resets the filter. \param poses of all cameras, camera → world  \param deviation standard deviation of each pose, metres at the
   *  scene's radius; 0.02 for a rig measured by hand  \throws pcl::BadArgumentException */
  FUSE_FLOW_INLINE void reset(const std::vector<Eigen::Isometry3d>& poses, double deviation);
  /** \brief \throws pcl::BadArgumentException for a value out of range */
  FUSE_FLOW_INLINE void setParameters(const PoseFilterParameters& parameters);
  /** \brief What setParameters() set, or the defaults. */
  const PoseFilterParameters& getParameters() const { return parameters_; }

  /** \brief Adds an estimate that began with poses(). \returns the cameras that, by this estimate, have moved */
  FUSE_FLOW_INLINE std::vector<CameraMotion> update(const ExtrinsicResult& estimate);

  /** \brief Camera → world, camera by camera. */
  const std::vector<Eigen::Isometry3d>& poses() const { return poses_; }
  /** \brief Standard deviation of a pose, metres at the scene's radius. */
  FUSE_FLOW_INLINE double deviation(std::size_t camera) const;
  /** \brief Whether the last estimate of a camera was held back. */
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
