#pragma once

#include <fuse_flow/calibration/extrinsic_parameters.h>
#include <fuse_flow/calibration/extrinsic_result.h>
#include <fuse_flow/device.h>
#include <fuse_flow/one_thread.h>
#include <fuse_flow/precompiled.h>
#include <fuse_flow/rig_frame.h>

#include <pcl/point_cloud.h>

#include <Eigen/Geometry>

#include <memory>
#include <vector>

namespace fuse_flow {

/** \brief Estimates all camera poses of a rig together, from the views of one or more instants.
 *
 *  Gauss–Newton over all cameras at once minimises point-to-plane residuals between every view and the views that overlap it most.
 *  Correspondences are found by projection into the other depth image. The points are chosen evenly over the directions of their normals.
 *  Tukey weights follow the scale of the residuals. Directions that the data do not determine keep their given values, unless colour
 *  determines them. An example is a slide of two cameras along the only wall that they see. The result names these directions.
 *
 *  \code
 *  fuse_flow::ExtrinsicEstimation<pcl::PointXYZRGB> estimation;
 *  estimation.addFrame(frame);
 *  const fuse_flow::ExtrinsicResult result = estimation.estimate();
 *  for (std::size_t i = 0; i < frame.cameras.size(); ++i) frame.cameras[i].T_world_camera = result.T_world_camera[i];
 *  \endcode
 *
 *  Only one thread at a time may use an object; a second thread gets a pcl::PCLException. Objects share nothing, so each thread may use its
 *  own object. */
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

  /** \brief Adds one instant; the necessary data are copied. The search begins with the poses of the first frame. \throws
   *  pcl::BadArgumentException if a camera or a view contradicts itself, or if the cameras differ from the earlier frames in more than
   *  their poses */
  void addFrame(const RigFrame& frame);

  /** \brief The same from organised clouds, each in the frame of its camera (z forward), as grabbers deliver them. A null cloud is missing.
   *  \throws pcl::BadArgumentException if a cloud does not have its camera's size */
  void addClouds(const std::vector<Camera>& cameras, const std::vector<PointCloudConstPtr>& clouds);

  /** \brief Begins with the poses that addFrame() was given. \throws pcl::PCLException without a frame */
  ExtrinsicResult estimate();

  /** \brief Begins with other poses, one for each camera. */
  ExtrinsicResult estimate(const std::vector<Eigen::Isometry3d>& initial);

 private:
  ExtrinsicParameters parameters_;
  int threads_{0};
  std::vector<Camera> cameras_;
  detail::OneThread one_thread_;
  std::unique_ptr<host::AlignmentSystem> system_;
};

}  // namespace fuse_flow

#ifndef FUSE_FLOW_DECLARATIONS_ONLY
#include <fuse_flow/impl/calibration/extrinsic_estimation.hpp>
#endif
