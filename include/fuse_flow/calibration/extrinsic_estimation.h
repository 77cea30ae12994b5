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
  detail::OneThread one_thread_;
  std::unique_ptr<host::AlignmentSystem> system_;
};

}  // namespace fuse_flow

#ifndef FUSE_FLOW_DECLARATIONS_ONLY
#include <fuse_flow/impl/calibration/extrinsic_estimation.hpp>
#endif
