#pragma once

#include <Eigen/Geometry>

#include <cstddef>
#include <vector>

namespace fuse_flow {

/** \brief The correction of one camera. */
struct CameraCorrection {
  /** \brief The new pose times the inverse of the given pose: world frame → world frame. */
  Eigen::Isometry3d T_correction = Eigen::Isometry3d::Identity();
  /** \brief Distance that the camera's centre moved, metres. */
  double translation{0};
  /** \brief Angle that the camera turned, radians. */
  double rotation{0};
  /** \brief Standard deviation of the centre relative to camera 0, along the directions that the data determine, metres. It is computed
   *  from the disagreement between parts of the images, so it includes noise that neighbouring pixels share. It does not include the risk
   *  that the search found a wrong solution. */
  double translation_deviation{0};
  double rotation_deviation{0};  ///< the same of its orientation, radians
  /** \brief Covariance of the twist about the scene's centre relative to camera 0: translation, metres, and rotation times the scene's
   *  radius; along the directions that the data determine. */
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  /** \brief Number of cameras whose views overlap enough for a comparison. */
  std::size_t neighbours{0};
  /** \brief Whether the data determine all six directions of the pose, relative to camera 0. */
  bool constrained{true};
  /** \brief If not: the unobservable directions. Each one is a unit twist: translation (metres) of the scene's centre, and rotation
   *  (radians times the scene's radius) about it; world frame. Along these directions, the camera keeps its given pose. */
  std::vector<Eigen::Matrix<double, 6, 1>> free_directions;
};

/** \brief Two cameras that see the same surfaces. */
struct CameraOverlap {
  std::size_t first{0};            ///< number of a camera
  std::size_t second{0};           ///< of another, larger
  std::size_t correspondences{0};  ///< number of correspondences
  double residual_before{0};       ///< root mean square distance of points to the other view's surface, metres
  double residual{0};              ///< the same at the new poses
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
  int iterations{0};          ///< until convergence
  bool converged{false};      ///< before max_iterations
};

}  // namespace fuse_flow
