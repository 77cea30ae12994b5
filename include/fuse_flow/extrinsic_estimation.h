#pragma once

#include <fuse_flow/device.h>
#include <fuse_flow/extrinsic_parameters.h>
#include <fuse_flow/precompiled.h>
#include <fuse_flow/rig_frame.h>

#include <pcl/point_cloud.h>

#include <Eigen/Geometry>

#include <memory>
#include <vector>

namespace fuse_flow {

/** \brief What became of one camera. */
struct CameraCorrection {
  /** \brief What was found, times the inverse of what was given: world frame → world frame. */
  Eigen::Isometry3d T_correction{Eigen::Isometry3d::Identity()};
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
  Eigen::Matrix<double, 6, 6> covariance{Eigen::Matrix<double, 6, 6>::Zero()};
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

/** \brief All camera poses of a rig together, from what its depth cameras see at one or more instants.
 *
 *  Point-to-plane residuals between every view and those that it overlaps most, counterparts by projection into the other
 *  depth image, points chosen evenly over the directions of their normals, Tukey's weights at the scale that the residuals
 *  have, Gauss–Newton over all cameras at once. What the data cannot tell, such as a slide of two cameras along the one wall
 *  that they see, stays as it was given, unless colour tells; the result says so.
 *
 *  \code
 *  fuse_flow::ExtrinsicEstimation<pcl::PointXYZRGB> estimation;
 *  estimation.addFrame(frame);
 *  const fuse_flow::ExtrinsicResult result = estimation.estimate();
 *  for (std::size_t i = 0; i < frame.cameras.size(); ++i) frame.cameras[i].T_world_camera = result.T_world_camera[i];
 *  \endcode */
template <typename PointT, typename Device = device::Host>
class ExtrinsicEstimation;

namespace host {
class AlignmentSystem;
}

/** \brief On the CPU. \copydetails ExtrinsicEstimation */
template <typename PointT>
class ExtrinsicEstimation<PointT, device::Host> {
 public:
  ///@{
  /** \brief As in PCL's classes. */
  using PointCloud = pcl::PointCloud<PointT>;
  using PointCloudConstPtr = typename PointCloud::ConstPtr;
  using Ptr = std::shared_ptr<ExtrinsicEstimation>;
  using ConstPtr = std::shared_ptr<const ExtrinsicEstimation>;
  ///@}

  ExtrinsicEstimation();
  ~ExtrinsicEstimation();

  /** \brief Throws pcl::BadArgumentException for a value out of range. */
  void setParameters(const ExtrinsicParameters& parameters);
  /** \brief What setParameters() set, or the defaults. */
  const ExtrinsicParameters& getParameters() const;

  /** \brief Threads to use; 0, the default, is one per core. */
  void setNumberOfThreads(unsigned int threads);

  /** \brief Forget all frames. */
  void clear();

  /** \brief One instant more; what is needed of it is copied. The poses of the first frame are where the search begins.
   *  \throws pcl::BadArgumentException if a camera or a view contradicts itself, or the cameras are not those of the frames
   *  before, poses aside */
  void addFrame(const RigFrame& frame);

  /** \brief The same from organised clouds, each in its camera's frame (z forward), as grabbers deliver them; null: missing.
   *  \throws pcl::BadArgumentException if a cloud does not have its camera's size */
  void addClouds(const std::vector<Camera>& cameras, const std::vector<PointCloudConstPtr>& clouds);

  /** \brief From the poses that addFrame() was given. \throws pcl::PCLException without a frame */
  ExtrinsicResult estimate();

  /** \brief From other poses, one a camera. */
  ExtrinsicResult estimate(const std::vector<Eigen::Isometry3d>& initial);

 private:
  ExtrinsicParameters parameters_;
  int threads_{0};
  std::vector<Camera> cameras_;
  std::unique_ptr<host::AlignmentSystem> system_;
};

}  // namespace fuse_flow

#ifndef FUSE_FLOW_DECLARATIONS_ONLY
#include <fuse_flow/impl/extrinsic_estimation.hpp>
#endif
