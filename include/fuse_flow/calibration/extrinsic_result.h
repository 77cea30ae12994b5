#pragma once

#include <Eigen/Geometry>

#include <cstddef>
#include <vector>

namespace fuse_flow {

/** \brief What became of one camera. */
struct CameraCorrection {
  /** \brief What was found, times the inverse of what was given: world frame → world frame. */
  Eigen::Isometry3d T_correction = Eigen::Isometry3d::Identity();
  /** \brief How far the camera's centre moved, metres. */
  double translation{0};
  /** \brief By how much it turned, radians. */
  double rotation{0};
  /** \brief Standard deviation of the centre relative to camera 0, along what the data tell, metres; from how much parts of the
   *  images disagree, so that noise that neighbouring pixels share counts. Of where the search ended: that it may be a wrong
   *  place altogether is not in it. */
  double translation_deviation{0};
  double rotation_deviation{0};  ///< the same of its orientation, radians
  /** \brief Of its twist about the scene's centre relative to camera 0: translation, metres, and rotation times the scene's
   *  radius; along what the data tell. */
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  /** \brief Cameras that share enough of what it sees to be compared. */
  std::size_t neighbours{0};
  /** \brief Whether the data tell all six of its directions, relative to camera 0. */
  bool constrained{true};
  /** \brief If not: what they leave open, each a unit twist: translation (metres) of the scene's centre, and rotation (radians
   *  times the scene's radius) about it; world frame. The camera was left where it was along these. */
  std::vector<Eigen::Matrix<double, 6, 1>> free_directions;
};

/** \brief Two cameras that see the same surfaces. */
struct CameraOverlap {
  std::size_t first{0};       ///< number of a camera
  std::size_t second{0};      ///< of another, larger
  std::size_t matches{0};     ///< counterparts found
  double residual_before{0};  ///< root mean square distance of points to the other view's surface, metres
  double residual{0};         ///< the same at the new poses
};

/** \brief What ExtrinsicEstimation found. */
struct ExtrinsicResult {
  std::vector<Eigen::Isometry3d> T_world_camera;  ///< camera by camera
  std::vector<CameraCorrection> corrections;      ///< camera by camera
  std::vector<CameraOverlap> overlaps;            ///< of all pairs that overlap
  Eigen::Vector3d scene_center{0, 0, 0};          ///< world, metres
  double scene_radius{1};                         ///< root mean square distance of the samples from it, metres
  double residual_before{0};  ///< root mean square point-to-plane distance at the given poses, metres
  double residual{0};         ///< at the new ones, metres
  int iterations{0};          ///< until nothing changed any more
  bool converged{false};      ///< before max_iterations
};

}  // namespace fuse_flow
